//! Finds wheels that do not do what the motors ask: stalled, or with an encoder that cannot be believed.
//!
//! Without a current sensor a blocked wheel and a silent encoder look alike from one wheel alone. An encoder is blamed
//! when it jumps, counts against a high duty, or has not counted once since arming while the other wheel has driven.

use crate::settings::Stall;
use crate::wheels::Wheel;

/// More than this in one tick is 4 m/s: no wheel does that.
const JUMP_COUNTS: u32 = 32;
/// Way of the other wheel after which a wheel that never counted has a silent encoder.
const SILENT_COUNTS: u32 = 150;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    Good,
    /// Number of the wheel: 0 left, 1 right.
    Stall(u8),
    Encoder(u8),
}

#[derive(Clone, Copy, Debug, Default)]
struct Watch {
    stalled_ticks: u32,
    backward_ticks: u32,
    /// Counts since arming, either way.
    counted: u32,
}

#[derive(Clone, Debug, Default)]
pub struct DriveCheck {
    watches: [Watch; 2],
}

impl DriveCheck {
    /// Forget everything, on arming.
    pub fn reset(&mut self) {
        *self = Self::default();
    }

    /// One tick while the motors are powered: counts of this tick, and the wheels after their measurement.
    pub fn tick(&mut self, steps: [i32; 2], wheels: &[Wheel; 2], limits: &Stall) -> Verdict {
        for ((watch, step), wheel) in self.watches.iter_mut().zip(steps).zip(wheels) {
            watch.counted = watch.counted.saturating_add(step.unsigned_abs());
            let (duty, velocity) = (i32::from(wheel.duty()), wheel.velocity_um_s());
            let strained = duty.abs() >= limits.duty || wheel.is_strained();
            let bound = limits.velocity;
            count_while(&mut watch.stalled_ticks, strained && velocity.abs() < bound);
            let against = velocity.abs() > bound && velocity.signum() != duty.signum();
            count_while(&mut watch.backward_ticks, strained && against);
        }
        let patience = limits.ticks;
        let limit_um = limits.following_error_um;
        let others = [self.watches[1], self.watches[0]];
        for (number, (((watch, other), step), wheel)) in (0..).zip(
            self.watches
                .iter()
                .zip(others)
                .zip(steps)
                .zip(wheels.iter()),
        ) {
            if step.unsigned_abs() > JUMP_COUNTS || watch.backward_ticks >= patience {
                return Verdict::Encoder(number);
            }
            let late = wheel.following_error_um().abs() > limit_um;
            if watch.stalled_ticks >= patience || late {
                let silent = watch.counted == 0 && other.counted > SILENT_COUNTS;
                return match silent {
                    true => Verdict::Encoder(number),
                    false => Verdict::Stall(number),
                };
            }
        }
        Verdict::Good
    }
}

/// Ticks for which a condition has held without a break.
fn count_while(ticks: &mut u32, condition: bool) {
    *ticks = if condition {
        ticks.saturating_add(1)
    } else {
        0
    };
}
