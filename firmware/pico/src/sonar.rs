//! One HC-SR04 at a time: trigger, then let go of the pin and time the echo pulse by its edges.
//!
//! Runs in the executor above the control loop, as a tick that delays the time stamp by 100 us would add 17 mm.

use embassy_rp::gpio::{Flex, Pull};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;
use embassy_time::{with_timeout, Duration, Instant, Timer};
use rover_core::SonarEcho;

use crate::crash::{self, task};
use crate::life;
use crate::pins::SonarPins;

/// Sensor to ping next; the core waits for each echo before it asks again.
pub static TRIGGER: Signal<CriticalSectionRawMutex, u8> = Signal::new();
/// The answer, at most one for each trigger: from a sensor that is not there none comes.
pub static ECHO: Signal<CriticalSectionRawMutex, SonarEcho> = Signal::new();

/// The datasheet asks for at least 10 us.
const TRIGGER_PULSE: Duration = Duration::from_micros(12);
/// The burst of 8 periods at 40 kHz is out after 0.2 ms and the echo line rises within 1 ms.
const RISE_TIMEOUT: Duration = Duration::from_millis(3);
/// 4 m there and back take 23.5 ms; without an obstacle the line stays high for 38 ms.
const FALL_TIMEOUT: Duration = Duration::from_millis(25);
/// Width of the echo pulse, 0 when the sensor heard nothing. None when it is the sensor itself that says nothing: its
/// line never rises (unplugged, without supply), or is still high from the ping before (stuck). The core counts those
/// and declares the sensor dead, where a time-out would mean that the way is free.
async fn ping(line: &mut Flex<'static>) -> Option<u32> {
    if line.is_high() {
        return None;
    }
    line.set_low();
    line.set_as_output();
    line.set_high();
    Timer::after(TRIGGER_PULSE).await;
    line.set_low();
    listen(line);
    if with_timeout(RISE_TIMEOUT, line.wait_for_high())
        .await
        .is_err()
    {
        return None;
    }
    let rise = Instant::now();
    let fell = with_timeout(FALL_TIMEOUT, line.wait_for_low()).await;
    Some(fell.map_or(0, |()| rise.elapsed().as_micros() as u32))
}

/// Pulled down, so that a line that is not connected never rises.
fn listen(line: &mut Flex<'static>) {
    line.set_pull(Pull::Down);
    line.set_as_input();
}

#[embassy_executor::task]
pub async fn run(sonars: SonarPins) {
    crash::within(task::SONAR, ping_them(sonars)).await
}

async fn ping_them(sonars: SonarPins) {
    let mut sonars = [sonars.left, sonars.centre, sonars.right];
    sonars.iter_mut().for_each(listen);
    loop {
        life::SONAR.show();
        let Ok(sensor) = with_timeout(life::IDLE, TRIGGER.wait()).await else {
            continue;
        };
        let Some(sonar) = sonars.get_mut(usize::from(sensor)) else {
            continue;
        };
        if let Some(echo_us) = ping(sonar).await {
            ECHO.signal(SonarEcho { sensor, echo_us });
        }
    }
}
