//! One axis of motion under constant jerk, integrated exactly in integers.
//!
//! Positions count 1e-15 m (or rad) and time counts ticks of 1 ms, because then a jerk in um/s^3 is a jerk in
//! 1e-15 m/tick^3 and needs no conversion. Velocity is held doubled and position six-fold, which makes the step of a
//! whole tick free of division, hence exact: p += v + a/2 + j/6, v += a + j/2, a += j.

use crate::fixed_point::{product, saturated, upper};

/// Six-fold position of one whole metre (or radian).
const WHOLE: i64 = 6_000_000_000_000_000;

/// State of one axis. With |v| <= 4 m/s and |a| <= 50 m/s^2 no step can overflow; `Limits` keeps it there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Axis {
    /// Whole metres, split off so that the six-fold remainder never grows.
    whole: i32,
    /// Six times the position beyond `whole`, in 1e-15 m; between -WHOLE and WHOLE.
    p6: i64,
    /// Twice the velocity in 1e-15 m per tick.
    v2: i64,
    /// Acceleration in 1e-15 m per tick^2, which is 1e-9 m/s^2.
    a: i64,
}

impl Axis {
    /// Advance by one whole tick under `jerk` (um/s^3).
    pub fn step(&mut self, jerk: i64) {
        self.p6 += 3 * self.v2 + 3 * self.a + jerk;
        self.v2 += 2 * self.a + jerk;
        self.a += jerk;
        self.carry();
    }

    /// Advance by `us` < 1000 microseconds. Every result is the floor of the exact value: the nested divisions give
    /// the same floor as one division by 1e9 (position) or 1e6 (velocity), without leaving 64 bits.
    pub fn partial(&mut self, jerk: i64, us: u32) {
        let k = i64::from(us);
        let cubic = (jerk * k * k * k).div_euclid(1000);
        let square = (3 * self.a * k * k + cubic).div_euclid(1000);
        self.p6 += (3 * self.v2 * k + square).div_euclid(1000);
        let linear = (jerk * k * k).div_euclid(1000);
        self.v2 += (2 * self.a * k + linear).div_euclid(1000);
        self.a += (jerk * k).div_euclid(1000);
        self.carry();
    }

    /// Velocity and acceleration after `ticks` whole ticks; the position is left alone.
    pub fn velocity_after(&mut self, jerk: i64, ticks: i64) {
        self.v2 += 2 * ticks * self.a + ticks * ticks * jerk;
        self.a += ticks * jerk;
    }

    /// Velocity and acceleration become exactly zero.
    pub fn rest(&mut self) {
        self.v2 = 0;
        self.a = 0;
    }

    /// No velocity and no acceleration.
    pub fn at_rest(&self) -> bool {
        self.v2 == 0 && self.a == 0
    }

    /// nm or nrad since the start.
    pub fn position_nano(&self) -> i64 {
        i64::from(self.whole) * 1_000_000_000 + self.p6.div_euclid(6_000_000)
    }

    /// um/s or urad/s, rounded down.
    pub fn velocity_micro(&self) -> i64 {
        self.v2.div_euclid(2_000_000)
    }

    /// um/s^2 or urad/s^2, rounded down.
    pub fn acceleration_micro(&self) -> i64 {
        self.a.div_euclid(1000)
    }

    /// The position as whole metres (or radians) and nm (or nrad) beyond, to 2 of these.
    pub fn whole_and_nano(&self) -> (i32, i32) {
        // 2^22 / 6e6 with 31 bits of fraction; `p6` has 53 bits, so that 31 are left.
        let nano = product((self.p6 >> 22) as i32, 1_501_199_876) >> 31;
        (self.whole, nano as i32)
    }

    /// um/s or urad/s for control: exactly zero at rest, otherwise to 1 of these.
    pub fn quick_velocity(&self) -> i32 {
        // 2^12 / 2e6 with 32 bits of fraction.
        upper(saturated(self.v2 >> 12), 8_796_093)
    }

    /// um/s or urad/s, never smaller than the truth when forwards, and not positive otherwise.
    pub fn velocity_above(&self) -> i64 {
        let margin = if self.v2 > 0 { 2 } else { 0 };
        i64::from(self.quick_velocity()) + margin
    }

    /// um/s^2 or urad/s^2 for control, as [`Self::quick_velocity`].
    pub fn quick_acceleration(&self) -> i32 {
        // 2^6 / 1000 with 32 bits of fraction.
        upper(saturated(self.a >> 6), 274_877_907)
    }

    /// The velocity and acceleration of a wheel, `half_um` to the right of the middle (negative: to the left).
    pub fn of_wheel(travel: &Self, heading: &Self, half_um: i64) -> Self {
        Self {
            v2: travel.v2 + heading.v2 / 1_000_000 * half_um,
            a: travel.a + heading.a * half_um / 1_000_000,
            ..Self::default()
        }
    }

    /// An axis under way, for tests: um/s and um/s^2.
    #[cfg(test)]
    pub fn with(velocity: i64, acceleration: i64) -> Self {
        Self {
            v2: velocity * 2_000_000,
            a: acceleration * 1000,
            ..Self::default()
        }
    }

    /// Keep `p6` small: whole metres move to their own counter.
    fn carry(&mut self) {
        if self.p6 >= WHOLE {
            self.p6 -= WHOLE;
            self.whole = self.whole.saturating_add(1);
        } else if self.p6 <= -WHOLE {
            self.p6 += WHOLE;
            self.whole = self.whole.saturating_sub(1);
        }
    }
}

/// What a segment may ask of an axis, in um and urad.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    pub velocity: i64,
    pub acceleration: i64,
}

impl Limits {
    /// Whether an axis that starts as `from` stays inside these limits for `ticks` under `jerk`. Acceleration is
    /// linear, so its extremes are at the ends; velocity may have one more where the acceleration crosses zero.
    pub fn hold(&self, from: &Axis, jerk: i64, ticks: i64) -> bool {
        let mut end = *from;
        end.velocity_after(jerk, ticks);
        let crosses = from.a.signum() * end.a.signum() < 0;
        let mut peak = *from;
        if crosses {
            peak.velocity_after(jerk, (-from.a).checked_div(jerk).unwrap_or(0));
        }
        self.allow(&end) && self.allow_velocity(&peak)
    }

    /// Limits of velocity alone.
    pub fn of_velocity(velocity: i64) -> Self {
        Self {
            velocity,
            acceleration: i64::MAX,
        }
    }

    /// Whether this very state is inside the limits.
    pub fn allow(&self, axis: &Axis) -> bool {
        axis.acceleration_micro().abs() <= self.acceleration && self.allow_velocity(axis)
    }

    fn allow_velocity(&self, axis: &Axis) -> bool {
        axis.velocity_micro().abs() <= self.velocity
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Exact value times a power of ten, so that the floor can be checked without rounding.
    fn exact_partial(axis: &Axis, jerk: i64, us: i64) -> (i64, i64, i64) {
        let (p6, v2, a) = (axis.p6 as i128, axis.v2 as i128, axis.a as i128);
        let (j, k) = (jerk as i128, us as i128);
        let p = p6 * 1_000_000_000 + 3 * v2 * k * 1_000_000 + 3 * a * k * k * 1000 + j * k * k * k;
        let v = v2 * 1_000_000 + 2 * a * k * 1000 + j * k * k;
        let a = a * 1000 + j * k;
        (
            p.div_euclid(1_000_000_000) as i64,
            v.div_euclid(1_000_000) as i64,
            a.div_euclid(1000) as i64,
        )
    }

    #[test]
    fn a_partial_tick_is_the_floor_of_the_exact_closed_form() {
        for (p6, v2, a, jerk) in [
            (0, 900_000_000_000, 1_500_000_000, 8_388_607),
            (5, -900_000_000_001, 1_499_999_999, -8_388_608),
            (-7, 3, -2_000_000_001, 1),
            (1, -1, 1, -1),
        ] {
            for us in [0, 1, 2, 499, 500, 998, 999] {
                let mut axis = Axis {
                    whole: 0,
                    p6,
                    v2,
                    a,
                };
                let expected = exact_partial(&axis, jerk, i64::from(us));
                axis.partial(jerk, us);
                assert_eq!((axis.p6, axis.v2, axis.a), expected, "us {us}");
            }
        }
    }

    #[test]
    fn what_control_goes_by_is_the_exact_state_to_two_nanometres_and_one_micrometre_per_second() {
        for n in -2_000..2_000_i64 {
            let axis = Axis {
                whole: (n / 7) as i32,
                p6: n * 2_999_999_999_123,
                v2: n * 3_999_999_877,
                a: n * 24_999_871,
            };
            let (whole, nano) = axis.whole_and_nano();
            let position = i64::from(whole) * 1_000_000_000 + i64::from(nano);
            assert!((position - axis.position_nano()).abs() <= 2, "{axis:?}");
            let velocity = i64::from(axis.quick_velocity());
            assert!((velocity - axis.velocity_micro()).abs() <= 1, "{axis:?}");
            let acceleration = i64::from(axis.quick_acceleration());
            assert!((acceleration - axis.acceleration_micro()).abs() <= 1);
        }
        assert_eq!(Axis::default().quick_velocity(), 0);
        for v2 in [1, 4_095, 2_000_000, 999_999_999_999] {
            let forwards = Axis {
                v2,
                ..Axis::default()
            };
            assert!(forwards.velocity_above() * 2_000_000 >= v2);
            let backwards = Axis {
                v2: -v2,
                ..Axis::default()
            };
            assert!(backwards.velocity_above() <= 0);
        }
    }

    #[test]
    fn whole_ticks_are_exact_over_sixteen_seconds() {
        let mut axis = Axis::default();
        let jerk = 5_999;
        for _ in 0..16_000 {
            axis.step(jerk);
        }
        let n = 16_000_i64;
        assert_eq!(axis.a, n * jerk);
        assert_eq!(axis.v2, n * n * jerk);
        let total = i128::from(axis.whole) * i128::from(WHOLE) + i128::from(axis.p6);
        assert_eq!(total, i128::from(n * n * n) * i128::from(jerk));
    }

    #[test]
    fn velocity_after_many_ticks_equals_many_steps() {
        let mut stepped = Axis {
            v2: 123_456,
            a: -9_876,
            ..Axis::default()
        };
        let mut jumped = stepped;
        for _ in 0..777 {
            stepped.step(-4_321);
        }
        jumped.velocity_after(-4_321, 777);
        assert_eq!((stepped.v2, stepped.a), (jumped.v2, jumped.a));
    }

    #[test]
    fn limits_see_a_peak_between_the_ends() {
        let limits = Limits {
            velocity: 100_000,
            acceleration: 1_000_000,
        };
        // 0.5 m/s^2 falling to -0.5 m/s^2 over 1 s from rest peaks at 0.125 m/s and comes back to zero.
        let from = Axis {
            a: 500_000_000,
            ..Axis::default()
        };
        assert!(!limits.hold(&from, -1_000_000, 1000));
        assert!(Limits {
            velocity: 126_000,
            ..limits
        }
        .hold(&from, -1_000_000, 1000));
    }
}
