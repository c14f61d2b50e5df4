//! Points and distances in the plane, metres.
//!
//! Only `sqrt`, never `hypot`: the plain Python reference repeats these operations one for one and must
//! get the same bits.

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    pub x: f64,
    pub y: f64,
}

impl Point {
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

pub fn distance_squared(a: Point, b: Point) -> f64 {
    let (dx, dy) = (b.x - a.x, b.y - a.y);
    dx * dx + dy * dy
}

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

pub fn path_length(path: &[Point]) -> f64 {
    path.windows(2).map(|pair| distance(pair[0], pair[1])).sum()
}
