//! One HC-SR04 at a time: trigger, then time the echo pulse by its edges.
//!
//! Runs in the executor above the control loop, as a tick that delays the time stamp by 100 us would add 17 mm.

use embassy_executor::task;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;
use embassy_time::{with_timeout, Duration, Instant, Timer};
use rover_core::SonarEcho;

use crate::life;
use crate::pins::SonarPins;

/// Sensor to ping next; the core waits for each echo before it asks again.
pub static TRIGGER: Signal<CriticalSectionRawMutex, u8> = Signal::new();
/// The answer, one for each trigger.
pub static ECHO: Signal<CriticalSectionRawMutex, SonarEcho> = Signal::new();

/// The datasheet asks for at least 10 us.
const TRIGGER_PULSE: Duration = Duration::from_micros(12);
/// The burst of 8 periods at 40 kHz is out after 0.2 ms and the echo line rises within 1 ms.
const RISE_TIMEOUT: Duration = Duration::from_millis(3);
/// 4 m there and back take 23.5 ms; without an obstacle the line stays high for 38 ms.
const FALL_TIMEOUT: Duration = Duration::from_millis(25);
/// Width of the echo pulse; 0 when there was none, or the line is stuck, or still high from the ping before.
async fn ping(sonar: &mut SonarPins) -> u32 {
    if sonar.echo.is_high() {
        return 0;
    }
    sonar.trigger.set_high();
    Timer::after(TRIGGER_PULSE).await;
    sonar.trigger.set_low();
    if with_timeout(RISE_TIMEOUT, sonar.echo.wait_for_high())
        .await
        .is_err()
    {
        return 0;
    }
    let rise = Instant::now();
    if with_timeout(FALL_TIMEOUT, sonar.echo.wait_for_low())
        .await
        .is_err()
    {
        return 0;
    }
    rise.elapsed().as_micros() as u32
}

#[task]
pub async fn run(mut sonars: [SonarPins; 3]) {
    loop {
        life::SONAR.show();
        let Ok(sensor) = with_timeout(life::IDLE, TRIGGER.wait()).await else {
            continue;
        };
        let echo_us = match sonars.get_mut(usize::from(sensor)) {
            Some(sonar) => ping(sonar).await,
            None => 0,
        };
        ECHO.signal(SonarEcho { sensor, echo_us });
    }
}
