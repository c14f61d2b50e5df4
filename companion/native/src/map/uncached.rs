//! A map that will be asked in few places: edges are checked against the cells themselves, and no clearance is computed
//! for them.

use crate::geometry::Point;
use crate::map::field::Field;

/// The same map, with every edge checked by `edge_clear`.
pub struct Uncached<'a, F: Field>(pub &'a F);

impl<F: Field> Field for Uncached<'_, F> {
    fn bounds(&self) -> (Point, Point) {
        self.0.bounds()
    }

    fn clearance(&self, p: Point) -> f64 {
        self.0.clearance(p)
    }

    fn clearance_at_least(&self, p: Point) -> f64 {
        self.0.clearance_at_least(p)
    }

    fn sweep_clear(&self, a: Point, b: Point, radius: f64) -> bool {
        self.0.sweep_clear(a, b, radius)
    }

    fn segment_clear(&self, a: Point, b: Point, radius: f64) -> bool {
        self.0.edge_clear(a, b, radius)
    }

    fn lattice_spacings(&self, radius: f64) -> Vec<f64> {
        self.0.lattice_spacings(radius)
    }
}
