//! What a planner asks of a map. Bounds count as walls.

use crate::geometry::Point;

/// Slack in metres that forgives rounding where the disc just touches a wall or a circle.
pub const TOUCH_M: f64 = 1e-9;

/// A map with walls around it, asked about discs and points; metres.
pub trait Field {
    /// Lower-left and upper-right corner.
    fn bounds(&self) -> (Point, Point);

    /// Distance from `p` to the nearest obstacle or wall; not positive inside.
    fn clearance(&self, p: Point) -> f64;

    /// A lower bound of the clearance that costs little.
    fn clearance_at_least(&self, p: Point) -> f64;

    /// False only when the clearance of `p` is less than `radius`.
    fn may_hold(&self, p: Point, radius: f64) -> bool {
        self.clearance(p) >= radius
    }

    /// A lower bound of the clearance of `p`, a point of a lattice; none when a disc of `radius` does not fit there.
    fn free_clearance(&self, p: Point, radius: f64) -> Option<f64> {
        let least = self.clearance_at_least(p);
        (least > radius || self.point_clear(p, radius)).then_some(least)
    }

    /// True when a disc of `radius` swept from `a` to `b` touches no obstacle (bounds not looked at).
    fn sweep_clear(&self, a: Point, b: Point, radius: f64) -> bool;

    /// `segment_clear` between two neighbouring points of a lattice at which the disc fits.
    fn hop_clear(&self, a: Point, b: Point, radius: f64) -> bool {
        self.segment_clear(a, b, radius)
    }

    /// `segment_clear` for an edge not much longer than the disc is wide, without computing clearance for it.
    fn short_clear(&self, a: Point, b: Point, radius: f64) -> bool {
        self.segment_clear(a, b, radius)
    }

    /// `segment_clear` for an edge of any length, without computing clearance for it.
    fn edge_clear(&self, a: Point, b: Point, radius: f64) -> bool {
        self.segment_clear(a, b, radius)
    }

    /// Spacings of the lattices on which to search a path for a disc of `radius`, coarse to fine; at least one.
    fn lattice_spacings(&self, radius: f64) -> Vec<f64>;

    /// Centre and radius of every obstacle, where all of them are circles.
    fn circular_obstacles(&self) -> Option<&[(Point, f64)]> {
        None
    }

    /// The finest of them: no detail that matters is smaller.
    fn lattice_spacing(&self) -> f64 {
        self.lattice_spacings(0.0)
            .last()
            .copied()
            .unwrap_or(f64::INFINITY)
    }

    /// True when the centre of a disc of `radius` may be at `p` as far as the walls are concerned.
    fn inside(&self, p: Point, radius: f64) -> bool {
        let (low, high) = self.bounds();
        p.x >= low.x + radius - TOUCH_M
            && p.y >= low.y + radius - TOUCH_M
            && p.x <= high.x - radius + TOUCH_M
            && p.y <= high.y - radius + TOUCH_M
    }

    /// The whole collision check of an edge. The bounds are convex: both ends inside is enough.
    fn segment_clear(&self, a: Point, b: Point, radius: f64) -> bool {
        self.inside(a, radius) && self.inside(b, radius) && self.sweep_clear(a, b, radius)
    }

    /// True when a disc of `radius` at `p` lies within the bounds and touches no obstacle.
    fn point_clear(&self, p: Point, radius: f64) -> bool {
        self.segment_clear(p, p, radius)
    }
}

/// Distance from `p` to the nearest wall, negative outside the bounds.
pub fn wall_distance(bounds: (Point, Point), p: Point) -> f64 {
    let (low, high) = bounds;
    (p.x - low.x)
        .min(high.x - p.x)
        .min(p.y - low.y)
        .min(high.y - p.y)
}
