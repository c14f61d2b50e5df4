//! The hardware watchdog, fed only when every task has shown life since the last time.

use core::sync::atomic::{AtomicBool, Ordering};

use embassy_rp::pac;
use embassy_rp::watchdog::Watchdog;
use embassy_time::{Duration, Ticker};

use crate::chip::WATCHDOG_STEPS_PER_US;
use crate::crash::{self, task};
use crate::reset;

/// A task that has stopped resets the chip after [`TIMEOUT`] and one [`CHECK`] at most: 5 cm at full speed. The reset
/// makes every pin an input, and the bridge's pull-downs stop the motors.
const TIMEOUT: Duration = Duration::from_millis(100);
/// The slowest task, a sonar without an echo, shows life each 43 ms, so in each third check.
const CHECK: Duration = Duration::from_millis(20);
/// How long a task may wait for work before it shows life again.
pub const IDLE: Duration = Duration::from_millis(15);

/// Erasing a sector takes 45 ms, and 400 ms when the flash is old; nothing else runs meanwhile.
const FLASH_WRITE_US: u32 = 800_000;

/// Give the watchdog time for one write to flash. Its next feeding goes back to [`TIMEOUT`].
pub fn allow_flash_write() {
    pac::WATCHDOG.load().write_value(pac::watchdog::regs::Load(
        WATCHDOG_STEPS_PER_US * FLASH_WRITE_US,
    ));
}

/// What one task sets and the watchdog clears.
pub struct Sign {
    shown: AtomicBool,
    retired: AtomicBool,
}

impl Sign {
    const fn new() -> Self {
        Self {
            shown: AtomicBool::new(false),
            retired: AtomicBool::new(false),
        }
    }

    /// Called by the task in each round.
    pub fn show(&self) {
        self.shown.store(true, Ordering::Relaxed);
    }

    /// The part is not fitted: nobody waits for its task any more.
    pub fn retire(&self) {
        self.retired.store(true, Ordering::Relaxed);
    }

    fn is_shown(&self) -> bool {
        self.shown.load(Ordering::Relaxed) || self.retired.load(Ordering::Relaxed)
    }

    fn clear(&self) {
        self.shown.store(false, Ordering::Relaxed);
    }
}

pub static CONTROL: Sign = Sign::new();
pub static LINK: Sign = Sign::new();
pub static CAN: Sign = Sign::new();
pub static SONAR: Sign = Sign::new();
pub static BATTERY: Sign = Sign::new();

const ALL: [(&Sign, u8); 5] = [
    (&CONTROL, task::CONTROL),
    (&LINK, task::LINK),
    (&CAN, task::CAN),
    (&SONAR, task::SONAR),
    (&BATTERY, task::BATTERY),
];

#[embassy_executor::task]
pub async fn run(watchdog: Watchdog) {
    crash::within(task::LIFE, look_after(watchdog)).await
}

async fn look_after(mut watchdog: Watchdog) {
    watchdog.pause_on_debug(true);
    reset::own(&mut watchdog);
    watchdog.start(TIMEOUT);
    crash::expect_feeding(TIMEOUT);
    let mut ticker = Ticker::every(CHECK);
    loop {
        ticker.next().await;
        let missing = ALL.iter().find(|(sign, _)| !sign.is_shown());
        crash::checked(missing.map_or(task::IDLE, |(_, task)| *task));
        if missing.is_none() {
            watchdog.feed(TIMEOUT);
            crash::expect_feeding(TIMEOUT);
            // A sign shown between the check and here is lost, which costs one check and not the chip.
            ALL.iter().for_each(|(sign, _)| sign.clear());
        }
    }
}
