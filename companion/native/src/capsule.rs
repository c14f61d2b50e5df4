//! All that is near a segment, row by row.

use crate::geometry::{distance, Point};

/// A segment, with what a row needs to know of it.
pub struct Capsule {
    a: Point,
    b: Point,
    length: f64,
    /// The direction from a to b, and one over each component; 0 where that has no meaning.
    along: Point,
    over: Point,
}

impl Capsule {
    pub fn new(a: Point, b: Point) -> Self {
        let length = distance(a, b);
        let along = if length > 0.0 {
            Point::new((b.x - a.x) / length, (b.y - a.y) / length)
        } else {
            Point::new(0.0, 0.0)
        };
        let inverse = |value: f64| if value.abs() < 1e-9 { 0.0 } else { 1.0 / value };
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
