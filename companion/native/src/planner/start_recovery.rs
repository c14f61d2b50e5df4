//! Recovers from a start that seems a little too near an obstacle, as localisation errors make it.

use crate::geometry::Point;
use crate::map::field::Field;

/// Directions that are tried, evenly around the start.
const DIRECTIONS: usize = 48;
/// Points that are tried in each direction.
const STRIDES: usize = 40;
/// Spacings of the finest lattice by which interpolated clearance may ripple.
const MAX_RIPPLE: f64 = 0.05;

/// The nearest point within `reach` of `start` where a disc of `radius` is clear, such that the clearance never
/// shrinks on the straight way there.
pub fn outward<F: Field>(field: &F, start: Point, radius: f64, reach: f64) -> Option<Point> {
    if reach <= 0.0 {
        return None;
    }
    // Interpolation between cells ripples; a circle's clearance does not.
    let ripple = MAX_RIPPLE * field.lattice_spacing();
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::circles::Circles;

    #[test]
    fn a_start_too_near_a_circle_is_left_straight_away_from_it() {
        let field = Circles::new(3.0, 3.0, vec![(Point::new(1.0, 1.0), 0.2)]);
        let start = Point::new(1.33, 1.0);
        let exit = outward(&field, start, 0.15, 0.1).expect("two centimetres are enough");
        assert!(field.point_clear(exit, 0.15));
        assert!(exit.x > start.x && (exit.y - start.y).abs() < 0.01);
        assert_eq!(outward(&field, start, 0.15, 0.01), None);
        assert_eq!(outward(&field, start, 0.15, 0.0), None);
    }
}
