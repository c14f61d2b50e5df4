//! One leg from scratch.

use crate::budget::Budget;
use crate::geometry::Point;
use crate::lattice::a_star;
use crate::lattice::graph::Lattice;
use crate::map::field::Field;
use crate::path::simplify::{self, Simplification};
use crate::random::Random;
use crate::tree::rrt::GrowthSettings;
use crate::tree::rrt_connect;

/// Tree extensions that RRT-Connect may take for a leg.
const MAX_LEG_EXTENSIONS: u64 = 400;
/// Sweeps of string pulling over a leg.
pub const SWEEPS: usize = 3;

/// What the search for shorter legs needs.
pub struct LegSearch<'a, F: Field> {
    /// The map.
    pub field: &'a F,
    /// How trees grow.
    pub growth: GrowthSettings,
    /// How legs are simplified.
    pub simplification: Simplification,
    /// Where random numbers come from.
    pub random: &'a mut Random,
    /// Iterations and time that are left.
    pub budget: &'a mut Budget,
}

impl<F: Field> LegSearch<'_, F> {
    /// A leg by RRT-Connect, simplified; and how many nodes were made.
    pub fn rrt_connect(&mut self, from: Point, to: Point) -> (Option<Vec<Point>>, usize) {
        let whole = self.budget.capped(MAX_LEG_EXTENSIONS);
        let (path, nodes) =
            rrt_connect::plan(self.field, from, to, self.growth, self.random, self.budget);
        self.budget.restore(whole);
        (path.map(|path| self.simplified(path)), nodes)
    }

    /// A leg by A* over the lattice, simplified; none when there is none or time is up.
    pub fn a_star(&self, lattice: &mut Lattice, from: Point, to: Point) -> Option<Vec<Point>> {
        let budget = &*self.budget;
        let found = a_star::search(lattice, self.field, from, &[to], || budget.late());
        let path = found.into_iter().next().flatten()?;
        Some(self.simplified(path))
    }

    /// The leg by A* if there is a lattice, or the shorter of `tree_path` and one by RRT-Connect; and how many nodes were
    /// made.
    pub fn fresh(
        &mut self,
        lattice: &mut Option<Lattice>,
        tree_path: impl FnOnce() -> Vec<Point>,
        (from, to): (Point, Point),
    ) -> (Vec<Point>, usize) {
        if let Some(lattice) = lattice.as_mut().filter(|_| !self.budget.late()) {
            if let Some(path) = self.a_star(lattice, from, to) {
                return (path, 0);
            }
        }
        let path = self.simplified(tree_path());
        if path.len() <= 2 {
            return (path, 0);
        }
        let (other, nodes) = self.rrt_connect(path[0], path[path.len() - 1]);
        match other {
            Some(other) if self.cost(&other) < self.cost(&path) => (other, nodes),
            _ => (path, nodes),
        }
    }

    /// The path, simplified cheaply.
    pub fn simplified(&self, mut path: Vec<Point>) -> Vec<Point> {
        simplify::simplify(self.field, &mut path, self.simplification, SWEEPS);
        path
    }

    /// Length of a path and what its corners cost, in metres.
    pub fn cost(&self, path: &[Point]) -> f64 {
        simplify::cost(path, self.simplification.corner_cost)
    }
}
