//! Battery voltage from the analogue-digital converter.

use core::sync::atomic::{AtomicU16, Ordering};

use embassy_executor::task;
use embassy_rp::adc::{Adc, Async, Channel, Config, InterruptHandler};
use embassy_rp::bind_interrupts;
use embassy_rp::gpio::Pull;
use embassy_time::{Duration, Ticker};

use crate::life;
use crate::pins::{BatteryPins, ADC_REFERENCE_MV, BATTERY_DIVIDER};

bind_interrupts!(struct Irqs {
    ADC_IRQ_FIFO => InterruptHandler;
});

const PERIOD: Duration = Duration::from_millis(10);
/// Conversions per value, against the ripple of the motors; 12 bits each, so their sum fits 16 bits.
const SAMPLES: u32 = 8;
const FULL_SCALE: u32 = 4_096 * SAMPLES;

static MILLIVOLTS: AtomicU16 = AtomicU16::new(0);

/// Latest voltage in mV.
pub fn millivolts() -> u16 {
    MILLIVOLTS.load(Ordering::Relaxed)
}

/// The converter with its pin.
pub struct Battery {
    adc: Adc<'static, Async>,
    channel: Channel<'static>,
}

impl Battery {
    pub fn new(pins: BatteryPins) -> Self {
        Self {
            adc: Adc::new(pins.adc, Irqs, Config::default()),
            channel: Channel::new_pin(pins.voltage, Pull::None),
        }
    }

    /// Measure once and publish. A conversion that failed leaves the last value as it is.
    pub async fn measure(&mut self) {
        let mut sum = 0;
        for _ in 0..SAMPLES {
            match self.adc.read(&mut self.channel).await {
                Ok(sample) => sum += u32::from(sample),
                Err(_) => return,
            }
        }
        let millivolts = sum * ADC_REFERENCE_MV * BATTERY_DIVIDER / FULL_SCALE;
        MILLIVOLTS.store(millivolts as u16, Ordering::Relaxed);
    }
}

#[task]
pub async fn run(mut battery: Battery) {
    let mut ticker = Ticker::every(PERIOD);
    loop {
        battery.measure().await;
        life::BATTERY.show();
        ticker.next().await;
    }
}
