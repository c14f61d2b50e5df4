//! Points and distances in the plane, metres.
//!
//! Only `sqrt`, never `hypot`: the plain Python reference repeats these operations one for one and must get the same
//! bits.

/// A point of the plane, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// To the right.
    pub x: f64,
    /// Upwards.
    pub y: f64,
}

impl Point {
    /// The point (x, y).
    pub fn new(x: f64, y: f64) -> Self {
        Self { x, y }
    }

    /// The point at `fraction` of the way to `other`.
    pub fn towards(self, other: Point, fraction: f64) -> Point {
        Point::new(
            self.x + (other.x - self.x) * fraction,
            self.y + (other.y - self.y) * fraction,
        )
    }
}

/// ‖a − b‖² in square metres.
pub fn distance_squared(a: Point, b: Point) -> f64 {
    let (dx, dy) = (b.x - a.x, b.y - a.y);
    dx * dx + dy * dy
}

/// ‖a − b‖ in metres.
pub fn distance(a: Point, b: Point) -> f64 {
    distance_squared(a, b).sqrt()
}

/// Squared distance from `p` to the segment `a`–`b`.
pub fn point_segment_squared(p: Point, a: Point, b: Point) -> f64 {
    let (dx, dy) = (b.x - a.x, b.y - a.y);
    let length_squared = dx * dx + dy * dy;
    let mut t = 0.0;
    if length_squared > 0.0 {
        t = ((p.x - a.x) * dx + (p.y - a.y) * dy) / length_squared;
        t = t.clamp(0.0, 1.0);
    }
    distance_squared(p, Point::new(a.x + t * dx, a.y + t * dy))
}

/// Length of the polyline in metres.
pub fn path_length(path: &[Point]) -> f64 {
    path.windows(2).map(|pair| distance(pair[0], pair[1])).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_point_of_a_segment_is_an_end_or_the_foot_of_the_perpendicular() {
        let (a, b) = (Point::new(0.0, 0.0), Point::new(4.0, 0.0));
        assert_eq!(point_segment_squared(Point::new(1.0, 2.0), a, b), 4.0);
        assert_eq!(point_segment_squared(Point::new(-3.0, 4.0), a, b), 25.0);
        assert_eq!(point_segment_squared(Point::new(7.0, 4.0), a, b), 25.0);
        assert_eq!(point_segment_squared(Point::new(3.0, 4.0), a, a), 25.0);
    }

    #[test]
    fn a_path_is_as_long_as_its_edges_and_a_point_has_no_length() {
        let path = [(0.0, 0.0), (3.0, 4.0), (3.0, 5.0)].map(|(x, y)| Point::new(x, y));
        assert_eq!(path_length(&path), 6.0);
        assert_eq!(path_length(&path[..1]), 0.0);
    }
}
