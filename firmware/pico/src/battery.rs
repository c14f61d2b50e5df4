//! Battery voltage: each tick takes the conversion that the last one began, and begins the next.

use embassy_rp::adc::{Adc, Blocking, Channel, Config};
use embassy_rp::gpio::Pull;
use embassy_rp::pac;
use embassy_time::Instant;

use crate::life;
use crate::pins::{BatteryPins, ADC_REFERENCE_MV, BATTERY_DIVIDER};

/// Conversions per value, against the ripple of the motors; 12 bits each.
const SAMPLES: u32 = 8;
const FULL_SCALE: u32 = 4_096;
/// A value is made at whole multiples of this time of the clock.
const VALUE_US: u64 = SAMPLES as u64 * 1_000;

/// The converter with its pin.
pub struct Battery {
    _adc: Adc<'static, Blocking>,
    _channel: Channel<'static>,
    sum: u32,
    count: u32,
    millivolts: u16,
}

impl Battery {
    /// Measure once, as the core must not see an empty battery at its first tick, then go on in the background.
    pub fn new(pins: BatteryPins) -> Self {
        let mut adc = Adc::new_blocking(pins.adc, Config::default());
        let mut channel = Channel::new_pin(pins.voltage, Pull::None);
        let mut sum = 0;
        for _ in 0..SAMPLES {
            sum += adc.blocking_read(&mut channel).map_or(0, u32::from);
        }
        pac::ADC.fcs().write(|w| {
            w.set_en(true);
            w.set_err(true);
        });
        Self {
            _adc: adc,
            _channel: channel,
            sum: 0,
            count: 0,
            millivolts: millivolts(sum, SAMPLES),
        }
    }

    /// Voltage in mV at the tick of time `now`. A conversion that failed is left out.
    pub fn measure(&mut self, now: Instant) -> u16 {
        while !pac::ADC.fcs().read().empty() {
            let sample = pac::ADC.fifo().read();
            if sample.err() {
                continue;
            }
            life::BATTERY.show();
            self.sum += u32::from(sample.val());
            self.count += 1;
        }
        if now.as_micros().is_multiple_of(VALUE_US) && self.count > 0 {
            self.millivolts = millivolts(self.sum, self.count);
            self.sum = 0;
            self.count = 0;
        }
        pac::ADC.cs().modify(|w| w.set_start_once(true));
        self.millivolts
    }
}

fn millivolts(sum: u32, count: u32) -> u16 {
    let full_scale = FULL_SCALE * count;
    (sum * ADC_REFERENCE_MV * BATTERY_DIVIDER)
        .checked_div(full_scale)
        .unwrap_or(0) as u16
}
