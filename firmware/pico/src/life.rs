//! The hardware watchdog, fed only when every task has shown life since the last time.

use core::sync::atomic::{AtomicBool, Ordering};

use embassy_executor::task;
use embassy_rp::watchdog::Watchdog;
use embassy_time::{Duration, Ticker};

/// A task that has stopped resets the chip after this long at most; the reset makes every pin an input, and the
/// bridge's pull-downs stop the motors.
const TIMEOUT: Duration = Duration::from_millis(400);
/// Every task wakes at least each 50 ms, so it is seen in each second check.
const CHECK: Duration = Duration::from_millis(60);

/// What one task sets and the watchdog clears.
pub struct Sign(AtomicBool);

impl Sign {
    const fn new() -> Self {
        Self(AtomicBool::new(false))
    }

    /// Called by the task in each round.
    pub fn show(&self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

pub static CONTROL: Sign = Sign::new();
pub static RECEIVE: Sign = Sign::new();
pub static TRANSMIT: Sign = Sign::new();
pub static SONAR: Sign = Sign::new();
pub static BATTERY: Sign = Sign::new();

const ALL: [&Sign; 5] = [&CONTROL, &RECEIVE, &TRANSMIT, &SONAR, &BATTERY];

#[task]
pub async fn run(mut watchdog: Watchdog) {
    watchdog.pause_on_debug(true);
    watchdog.start(TIMEOUT);
    let mut ticker = Ticker::every(CHECK);
    loop {
        ticker.next().await;
        if ALL.iter().all(|sign| sign.0.load(Ordering::Relaxed)) {
            watchdog.feed(TIMEOUT);
            // A sign shown between the check and here is lost, which costs one check and not the chip.
            ALL.iter()
                .for_each(|sign| sign.0.store(false, Ordering::Relaxed));
        }
    }
}
