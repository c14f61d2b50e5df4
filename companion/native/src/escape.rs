//! The way out when the robot stands a little too near an obstacle, as localisation errors make it seem.

use crate::field::Field;
use crate::geometry::Point;

const DIRECTIONS: usize = 48;
const STRIDES: usize = 40;

/// The nearest point within `reach` of `start` where a disc of `radius` is clear, such that the clearance never
/// shrinks on the straight way there.
pub fn outward<F: Field>(field: &F, start: Point, radius: f64, reach: f64) -> Option<Point> {
    if reach <= 0.0 {
        return None;
    }
    // Interpolation between cells ripples; a circle's clearance does not.
    let ripple = 0.05 * field.lattice_spacing();
    let mut best: Option<(usize, f64, Point)> = None;
    for direction in 0..DIRECTIONS {
        let angle = std::f64::consts::TAU * direction as f64 / DIRECTIONS as f64;
        let (sin, cos) = angle.sin_cos();
        let mut highest = field.clearance(start);
        for stride in 1..=STRIDES {
            let along = reach * stride as f64 / STRIDES as f64;
            let p = Point::new(start.x + along * cos, start.y + along * sin);
            let clearance = field.clearance(p);
            if clearance < highest - ripple {
                break;
            }
            highest = highest.max(clearance);
            if field.point_clear(p, radius) {
                let nearer =
                    best.is_none_or(|(s, c, _)| stride < s || (stride == s && clearance > c));
                if nearer {
                    best = Some((stride, clearance, p));
                }
                break;
            }
        }
    }
    best.map(|(_, _, p)| p)
}
