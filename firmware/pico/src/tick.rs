//! The control loop's millisecond, from an alarm of the timer of its own.
//!
//! The executor's timers share one alarm and a queue that is walked at each of them: too much for what comes a thousand
//! times a second.

use core::future::poll_fn;
use core::task::Poll;

use embassy_sync::waitqueue::AtomicWaker;
use embassy_time::{Duration, Instant};

use crate::chip::TIMER;

const ALARM: usize = 1;

static WAKER: AtomicWaker = AtomicWaker::new();

/// From the alarm's interrupt.
pub fn on_interrupt() {
    TIMER.intr().write(|w| w.set_alarm(ALARM, true));
    WAKER.wake();
}

/// Nominal times, one period apart: jitter of the start does not reach the motion, a late one is made up for.
pub struct Ticker {
    period: Duration,
    next: Instant,
}

impl Ticker {
    pub fn every(period: Duration) -> Self {
        TIMER.inte().modify(|w| w.set_alarm(ALARM, true));
        // On whole periods of the clock: the core's times are the same on every board and at every start.
        let elapsed = Instant::now().as_ticks();
        let begun = elapsed.checked_rem(period.as_ticks()).unwrap_or(0);
        Self {
            period,
            next: Instant::from_ticks(elapsed.saturating_sub(begun)),
        }
    }

    /// Wait for the next one and return its nominal time.
    pub async fn next(&mut self) -> Instant {
        self.next += self.period;
        let next = self.next;
        poll_fn(|context| {
            WAKER.register(context.waker());
            TIMER.alarm(ALARM).write_value(next.as_micros() as u32);
            // The alarm compares for equality, so one that is set too late never comes: look after setting it.
            if Instant::now() < next {
                Poll::Pending
            } else {
                Poll::Ready(next)
            }
        })
        .await
    }
}
