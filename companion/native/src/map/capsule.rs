//! A capsule: all points near a segment, row by row.

use crate::geometry::{distance, Point};

/// Components of a direction below which a row or column runs along it.
const MIN_COMPONENT: f64 = 1e-9;

/// A segment, with what a row needs to know of it.
pub struct Capsule {
    a: Point,
    b: Point,
    length: f64,
    /// The direction from a to b.
    along: Point,
    /// One over each of its components; 0 where that has no meaning.
    over: Point,
}

impl Capsule {
    /// Around the segment `a`–`b`.
    pub fn new(a: Point, b: Point) -> Self {
        let length = distance(a, b);
        let along = if length > 0.0 {
            Point::new((b.x - a.x) / length, (b.y - a.y) / length)
        } else {
            Point::new(0.0, 0.0)
        };
        let inverse = |value: f64| {
            if value.abs() < MIN_COMPONENT {
                0.0
            } else {
                1.0 / value
            }
        };
        let over = Point::new(inverse(along.x), inverse(along.y));
        Self {
            a,
            b,
            length,
            along,
            over,
        }
    }

    /// From where to where points at this `y` are at most `radius` away from the segment; from more to less when none is.
    pub fn span(&self, y: f64, radius: f64) -> (f64, f64) {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for end in [self.a, self.b] {
            let square = radius * radius - (y - end.y) * (y - end.y);
            if square >= 0.0 {
                let half = square.sqrt();
                low = low.min(end.x - half);
                high = high.max(end.x + half);
            }
        }
        let up = y - self.a.y;
        let (mut from, mut to) = (f64::NEG_INFINITY, f64::INFINITY);
        let mut within = |first: f64, second: f64| {
            from = from.max(first.min(second));
            to = to.min(first.max(second));
        };
        // Beside the line itself, and between its ends.
        if self.over.y != 0.0 {
            let middle = self.along.x * up;
            within(
                (middle - radius) * self.over.y,
                (middle + radius) * self.over.y,
            );
        } else if up.abs() > radius || self.length == 0.0 {
            return (low, high);
        }
        if self.over.x != 0.0 {
            let gone = self.along.y * up;
            within(-gone * self.over.x, (self.length - gone) * self.over.x);
        } else if up * self.along.y < 0.0 || up * self.along.y > self.length {
            return (low, high);
        }
        if from <= to {
            low = low.min(self.a.x + from);
            high = high.max(self.a.x + to);
        }
        (low, high)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::point_segment_squared;
    use crate::random::Random;

    #[test]
    fn a_row_is_cut_exactly_where_points_are_near_the_segment() {
        let mut random = Random::new(2);
        let mut point = || Point::new(4.0 * random.uniform(), 4.0 * random.uniform());
        for _ in 0..300 {
            let (a, b) = (point(), point());
            let (radius, y) = (0.7, point().y);
            let (from, to) = Capsule::new(a, b).span(y, radius);
            for step in 0..200 {
                let x = -1.0 + 0.03 * f64::from(step);
                let squared = point_segment_squared(Point::new(x, y), a, b);
                if (squared.sqrt() - radius).abs() > 1e-6 {
                    assert_eq!((from..=to).contains(&x), squared < radius * radius);
                }
            }
        }
    }

    #[test]
    fn level_upright_and_pointlike_segments_have_rows_too() {
        let p = Point::new(1.0, 1.0);
        assert_eq!(
            Capsule::new(p, Point::new(3.0, 1.0)).span(1.0, 0.5),
            (0.5, 3.5)
        );
        assert_eq!(
            Capsule::new(p, Point::new(1.0, 3.0)).span(2.0, 0.5),
            (0.5, 1.5)
        );
        assert_eq!(Capsule::new(p, p).span(1.0, 0.5), (0.5, 1.5));
        let (from, to) = Capsule::new(p, p).span(2.0, 0.5);
        assert!(from > to);
    }
}
