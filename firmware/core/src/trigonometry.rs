//! Sine and cosine in integers: no tables, no floating point, the same bits on every machine.

use crate::fixed_point::product;

/// One in Q30.
pub const ONE: i64 = 1 << 30;
/// 2^32 / (2 pi 1e6), in Q32: microradians to binary angle, where 2^32 is a full turn.
const TURN_PER_MICRORADIAN_Q32: i64 = 2_935_890_503_282;

/// Sine and cosine (Q30) of an angle in microradians, any number of turns. Error below 3e-8.
pub fn sine_cosine(angle_urad: i64) -> (i64, i64) {
    // The product's low 64 bits hold 32 bits of angle and 32 of fraction; whole turns fall off the top.
    let turn = (angle_urad.wrapping_mul(TURN_PER_MICRORADIAN_Q32) >> 32) as u32;
    // To the nearest quarter turn, and what is beyond it: -45 to 45 degrees.
    let quadrant = turn.wrapping_add(1 << 29) >> 30;
    let rest = turn.wrapping_sub(quadrant << 30) as i32;
    // Binary angle to radians in Q30: times 2 pi / 4, as 2^30 is a quarter turn.
    let x = times(rest, 1_686_629_713);
    let (sine, cosine) = octant(x);
    let (sine, cosine) = (i64::from(sine), i64::from(cosine));
    match quadrant & 3 {
        0 => (sine, cosine),
        1 => (cosine, -sine),
        2 => (-sine, -cosine),
        _ => (-cosine, sine),
    }
}

/// Taylor series for |x| <= pi/4 (Q30), by Horner's rule.
fn octant(x: i32) -> (i32, i32) {
    let one = ONE as i32;
    let z = times(x, x);
    let chain = |divisors: [i32; 4]| {
        divisors.iter().fold(one, |sum, divisor| {
            one - times(times(z, sum), one / divisor)
        })
    };
    // sin x = x (1 - z/6 (1 - z/20 (1 - z/42 (1 - z/72))))
    let sine = times(x, chain([72, 42, 20, 6]));
    let cosine = chain([56, 30, 12, 2]);
    (sine, cosine)
}

/// Product of two numbers in Q30 that stay below 2.
fn times(a: i32, b: i32) -> i32 {
    (product(a, b) >> 30) as i32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_floating_point_over_many_turns() {
        let mut worst = 0.0_f64;
        for i in -40_000..40_000_i64 {
            let angle = i * 1_571 + i * i % 997;
            let (sine, cosine) = sine_cosine(angle);
            let radians = angle as f64 / 1e6;
            worst = worst.max((sine as f64 / ONE as f64 - radians.sin()).abs());
            worst = worst.max((cosine as f64 / ONE as f64 - radians.cos()).abs());
        }
        assert!(worst < 6e-8, "{worst}");
    }

    #[test]
    fn holds_at_extreme_angles_without_panicking() {
        for angle in [i64::MIN, -1, 0, 1, i64::MAX] {
            let (s, c) = sine_cosine(angle);
            assert!(((s * s + c * c) as f64 / (ONE * ONE) as f64 - 1.0).abs() < 1e-6);
        }
    }
}
