//! The inertial sensor, an LSM6DSO on I2C: asked every 4 ms by the control loop, answered before its next tick.
//!
//! Optional, so nobody waits for it: each transfer is bounded in time, one that hangs is dropped with the bus and begun
//! anew, and the watchdog does not ask for this task. While nobody answers, it is looked for at every tenth of a second.

use embassy_rp::i2c::{Async, Config, I2c};
use embassy_rp::interrupt::{InterruptExt, Priority};
use embassy_rp::peripherals::I2C0;
use embassy_rp::{bind_interrupts, i2c, interrupt};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;
use embassy_time::{with_timeout, Duration, Instant};
use rover_core::InertialSample;
use rover_lsm6dso::Lsm6dso;

use crate::crash::{self, task};
use crate::pins::InertialPins;

bind_interrupts!(struct Interrupts {
    I2C0_IRQ => i2c::InterruptHandler<I2C0>;
});

const FREQUENCY_HZ: u32 = 400_000;
/// Milliseconds between two samples, and between two looks for a sensor; whole multiples of the clock. As in
/// firmware/sitl/src/inertial.rs.
const SAMPLE_MS: u64 = 4;
const LOOK_MS: u64 = 100;
/// A burst takes 0.4 ms.
const READ_TIMEOUT: Duration = Duration::from_micros(900);
const START_TIMEOUT: Duration = Duration::from_millis(3);
/// Bursts in a row that fail until the sensor is looked for anew.
const FAILURES: u32 = 5;

/// The tick at which to ask.
static WANTED: Signal<CriticalSectionRawMutex, Instant> = Signal::new();
/// The answer, at most one for each question.
static SAMPLE: Signal<CriticalSectionRawMutex, InertialSample> = Signal::new();

/// From the control loop, at its tick of time `now`: what has come since the last question, and the next question.
pub fn take(now: Instant) -> Option<InertialSample> {
    if now.as_millis().is_multiple_of(SAMPLE_MS) {
        WANTED.signal(now);
    }
    SAMPLE.try_take()
}

#[embassy_executor::task]
pub async fn run(pins: InertialPins) {
    crash::within(task::INERTIAL, ask(pins)).await
}

async fn ask(mut pins: InertialPins) {
    loop {
        let mut sensor = Lsm6dso::new(bus(&mut pins));
        while !WANTED.wait().await.as_millis().is_multiple_of(LOOK_MS) {}
        if matches!(
            with_timeout(START_TIMEOUT, sensor.start()).await,
            Ok(Ok(()))
        ) {
            sample(&mut sensor).await;
        }
    }
}

/// Until it fails.
async fn sample(sensor: &mut Lsm6dso<I2c<'_, I2C0, Async>>) {
    let mut failures = 0;
    while failures < FAILURES {
        WANTED.wait().await;
        match with_timeout(READ_TIMEOUT, sensor.read()).await {
            Ok(Ok(reading)) => {
                failures = 0;
                SAMPLE.signal(InertialSample {
                    gyro: reading.gyro,
                    acceleration: reading.acceleration,
                    temperature: reading.temperature,
                });
            }
            _ => failures += 1,
        }
    }
}

/// The block after a reset, so that nothing of a transfer that was dropped is left in it.
fn bus(pins: &mut InertialPins) -> I2c<'_, I2C0, Async> {
    let mut config = Config::default();
    config.frequency = FREQUENCY_HZ;
    interrupt::I2C0_IRQ.set_priority(Priority::P3);
    I2c::new_async(
        pins.i2c.reborrow(),
        pins.clock.reborrow(),
        pins.data.reborrow(),
        Interrupts,
        config,
    )
}
