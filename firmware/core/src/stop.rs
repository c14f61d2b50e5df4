//! The jerk-limited stop: from any velocity and acceleration of one axis to rest, in at most three phases.

use crate::axis::Axis;

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Phase {
    /// um/s^3.
    jerk: i64,
    left_us: u32,
}

/// Brings one axis to rest in the shortest time that the limits allow.
#[derive(Clone, Copy, Debug, Default)]
pub struct AxisStop {
    phases: [Phase; 3],
}

impl AxisStop {
    /// Plan from the state of `axis`; `acceleration` in um/s^2 and `jerk` in um/s^3, both positive.
    ///
    /// Bring the acceleration to -peak, hold it, bring it back to zero. With v + a|a|/2j > 0 (the velocity that is
    /// left when the acceleration is taken to zero at once) the peak is sqrt(jv + a^2/2), cut off at the limit.
    pub fn plan(axis: &Axis, acceleration: i64, jerk: i64) -> Self {
        let jerk = jerk.max(1);
        let limit = acceleration.max(1);
        let (v, a) = (axis.velocity_micro(), axis.acceleration_micro());
        let left_over = v + quotient(a * a.abs(), 2 * jerk);
        // Mirror so that the velocity to be taken away is positive.
        let sign = if left_over < 0 { -1 } else { 1 };
        let (v, a) = (v * sign, a * sign);
        let under_root = jerk.saturating_mul(v).saturating_add(a * a / 2).max(0);
        let peak = (under_root.unsigned_abs().isqrt() as i64).min(limit);
        let change = a + peak;
        let first = change.abs();
        let taken_first = quotient((a - peak) * first, 2 * jerk);
        let taken_last = quotient(peak * peak, 2 * jerk);
        let held = (v + taken_first - taken_last).max(0);
        Self {
            phases: [
                Phase {
                    jerk: -jerk * sign * change.signum(),
                    left_us: microseconds(first, jerk),
                },
                Phase {
                    jerk: 0,
                    left_us: microseconds(held, peak),
                },
                Phase {
                    jerk: jerk * sign,
                    left_us: microseconds(peak, jerk),
                },
            ],
        }
    }

    /// Advance `axis` by `us`; true when it is at rest. What rounding has left over (some um/s) is dropped then.
    pub fn advance(&mut self, axis: &mut Axis, us: u32) -> bool {
        let mut left = us;
        for phase in &mut self.phases {
            let mut piece = left.min(phase.left_us);
            left -= piece;
            phase.left_us -= piece;
            while piece >= 1000 {
                axis.step(phase.jerk);
                piece -= 1000;
            }
            if piece > 0 {
                axis.partial(phase.jerk, piece);
            }
        }
        let done = self.phases.iter().all(|phase| phase.left_us == 0);
        if done {
            axis.rest();
        }
        done
    }

    /// How long the stop still takes.
    #[cfg(test)]
    pub fn remaining_us(&self) -> u32 {
        self.phases
            .iter()
            .fold(0, |sum, phase| phase.left_us.saturating_add(sum))
    }
}

fn quotient(numerator: i64, denominator: i64) -> i64 {
    numerator.checked_div(denominator).unwrap_or(0)
}

/// `change / rate` in microseconds, at most 20 s.
fn microseconds(change: i64, rate: i64) -> u32 {
    quotient(change.saturating_mul(1_000_000), rate).clamp(0, 20_000_000) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_state_comes_to_rest_within_the_limits_of_jerk_and_acceleration() {
        let (limit, jerk) = (800_000, 6_000_000);
        for v in [-450_000, -250_000, -3_000, 0, 10, 40_000, 250_000, 450_000] {
            for a in [-1_200_000, -500_000, -1_000, 0, 700, 500_000, 1_200_000] {
                let mut axis = Axis::with(v, a);
                let mut stop = AxisStop::plan(&axis, limit, jerk);
                let planned_us = stop.remaining_us();
                let (mut last_a, mut last_v) = (axis.acceleration_micro(), axis.velocity_micro());
                let mut ticks = 0;
                while !stop.advance(&mut axis, 1000) {
                    let a_now = axis.acceleration_micro();
                    assert!((a_now - last_a).abs() <= jerk / 1000 + 1, "jerk at {v} {a}");
                    assert!(a_now.abs() <= limit.max(a.abs() + jerk / 1000) + 6_000);
                    (last_a, last_v) = (a_now, axis.velocity_micro());
                    ticks += 1;
                    assert!(ticks < 5000);
                }
                assert!(axis.at_rest());
                // The rest that was dropped is what one tick of braking takes away.
                assert!(last_v.abs() <= 1_000, "left {last_v} um/s at {v} {a}");
                assert!(planned_us.abs_diff(ticks * 1000) <= 2_000);
            }
        }
    }

    #[test]
    fn a_stop_from_cruise_takes_the_time_and_length_of_the_closed_form() {
        let mut axis = Axis::with(250_000, 0);
        let v = axis.velocity_micro() as f64 / 1e6;
        let from = axis.position_nano();
        let mut stop = AxisStop::plan(&axis, 800_000, 6_000_000);
        let time = f64::from(stop.remaining_us()) / 1e6;
        while !stop.advance(&mut axis, 1000) {}
        let length = (axis.position_nano() - from) as f64 / 1e9;
        let expected_time = v / 0.8 + 0.8 / 6.0;
        assert!(
            (time - expected_time).abs() < 1e-5,
            "{time} {expected_time}"
        );
        assert!((length - v / 2.0 * expected_time).abs() < 2e-6);
    }

    #[test]
    fn an_axis_at_rest_needs_no_stop() {
        let mut axis = Axis::default();
        assert!(AxisStop::plan(&axis, 800_000, 6_000_000).advance(&mut axis, 1000));
        assert_eq!(axis, Axis::default());
    }
}
