//! One leg from scratch: by trees, over a lattice, or both.

use std::time::Instant;

use crate::budget::Budget;
use crate::geometry::{distance, Point};
use crate::lattice::a_star;
use crate::lattice::cache::LatticeCache;
use crate::lattice::feasibility::{self, Feasibility};
use crate::lattice::graph::Lattice;
use crate::map::field::Field;
use crate::path::simplify::{self, Simplification};
use crate::planner::stages::Stages;
use crate::random::Random;
use crate::tangent;
use crate::tree::rrt::{GrowingTree, GrowthSettings};
use crate::tree::rrt_connect;

/// Tree extensions that RRT-Connect may take for a leg.
const MAX_LEG_EXTENSIONS: u64 = 400;
/// Sweeps of string pulling over a leg.
const SWEEPS: usize = 3;
/// The same where it has to be quick.
const QUICK_SWEEPS: usize = 2;
/// Share of the way by which string pulling then moves a vertex at least.
const QUICK_LEAST_MOVE: f64 = 1.0 / 8.0;
/// Cells of the lattice that a leg is searched on, at most, unless the coarsest has more.
const MAX_CELLS: f64 = 4_000_000.0;

/// What the search for legs needs.
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
    /// Lattices of this map.
    pub lattices: &'a mut LatticeCache,
    /// What has run.
    pub stages: &'a mut Stages,
}

impl<F: Field> LegSearch<'_, F> {
    /// Grows a tree towards its goals by so many extensions at most.
    pub fn grow(&mut self, tree: &mut GrowingTree, goals: &[Point], wanted: &[bool], most: u64) {
        let (began, used, nodes) = (Instant::now(), self.budget.used, tree.tree.points.len());
        let whole = self.budget.capped(most);
        tree.grow(
            self.field,
            goals,
            wanted,
            self.growth,
            self.random,
            self.budget,
        );
        self.budget.restore(whole);
        self.stages.record("tree", began, self.budget.used - used);
        self.stages.nodes += tree.tree.points.len() - nodes;
    }

    /// A leg by RRT-Connect, simplified.
    pub fn rrt_connect(&mut self, from: Point, to: Point) -> Option<Vec<Point>> {
        let (began, used) = (Instant::now(), self.budget.used);
        let whole = self.budget.capped(MAX_LEG_EXTENSIONS);
        let (path, nodes) =
            rrt_connect::plan(self.field, from, to, self.growth, self.random, self.budget);
        self.budget.restore(whole);
        (self.stages).record("rrt-connect", began, self.budget.used - used);
        self.stages.nodes += nodes;
        path.map(|path| self.simplified(path))
    }

    /// A leg by A* over the lattice, simplified; none when there is none or time is up.
    pub fn a_star(&mut self, lattice: &mut Lattice, from: Point, to: Point) -> Option<Vec<Point>> {
        let began = Instant::now();
        let budget = &*self.budget;
        let found = a_star::search(lattice, self.field, from, &[to], || budget.late());
        self.stages.record("lattice", began, found.expanded);
        self.stages.nodes += found.labelled;
        let path = found.paths.into_iter().next().flatten()?;
        Some(self.quickly_simplified(path))
    }

    /// The shortest leg of tangents and arcs that is shorter than `bound` metres; none where the map is not made of circles,
    /// there is no such leg, more than `most` circles have to be looked at, or time is up.
    pub fn tangents(
        &mut self,
        from: Point,
        to: Point,
        (bound, most): (f64, usize),
    ) -> Option<Vec<Point>> {
        let obstacles = self.field.circular_obstacles()?;
        let began = Instant::now();
        let (budget, radius) = (&*self.budget, self.growth.radius);
        let late = || budget.late();
        let limits = (bound, most);
        let found =
            tangent::path::shortest(self.field, obstacles, (from, to), radius, limits, late);
        self.stages.record("tangents", began, found.iterations);
        self.stages.nodes += found.iterations as usize;
        found.path
    }

    /// The finest lattice that is not too large to be searched as a whole.
    pub fn take_lattice(&mut self) -> Lattice {
        let (low, high) = self.field.bounds();
        let area = (high.x - low.x) * (high.y - low.y);
        let spacings = self.field.lattice_spacings(self.growth.radius);
        let affordable = |&&spacing: &&f64| area <= MAX_CELLS * spacing * spacing;
        let spacing = spacings.iter().rev().find(affordable);
        let spacing = *spacing.unwrap_or(&spacings[0]);
        self.lattices.take(self.field, spacing, self.growth.radius)
    }

    /// A path over lattices of any spacing, or what is known of the reason why there is none.
    pub fn first_lattice_path(&mut self, from: Point, to: Point) -> Feasibility {
        let began = Instant::now();
        let found = feasibility::first_path(self.field, from, to, self.growth.radius);
        self.stages.record("lattice", began, 0);
        found
    }

    /// The leg by A* if there is a lattice, or the shorter of `tree_path` and one by RRT-Connect.
    pub fn fresh(
        &mut self,
        lattice: &mut Option<Lattice>,
        tree_path: impl FnOnce() -> Vec<Point>,
        (from, to): (Point, Point),
    ) -> Vec<Point> {
        if let Some(lattice) = lattice.as_mut().filter(|_| !self.budget.late()) {
            if let Some(path) = self.a_star(lattice, from, to) {
                return path;
            }
        }
        let path = self.simplified(tree_path());
        if path.len() <= 2 {
            return path;
        }
        match self.rrt_connect(path[0], path[path.len() - 1]) {
            Some(other) if self.cost(&other) < self.cost(&path) => other,
            _ => path,
        }
    }

    /// The path, simplified cheaply.
    pub fn simplified(&mut self, mut path: Vec<Point>) -> Vec<Point> {
        let began = Instant::now();
        simplify::simplify(self.field, &mut path, self.simplification, SWEEPS);
        self.stages.record("simplify", began, 1);
        path
    }

    /// The path, simplified still more cheaply: for one that is nearly the shortest, or will soon be replaced.
    pub fn quickly_simplified(&mut self, mut path: Vec<Point>) -> Vec<Point> {
        let began = Instant::now();
        let quick = Simplification {
            least_move: QUICK_LEAST_MOVE,
            ..self.simplification
        };
        simplify::simplify(self.field, &mut path, quick, QUICK_SWEEPS);
        self.stages.record("simplify", began, 1);
        path
    }

    /// Length of a path and what its corners cost, in metres.
    pub fn cost(&self, path: &[Point]) -> f64 {
        simplify::cost(path, self.simplification.corner_cost)
    }

    /// Cost of a path over the distance between its ends: 1 for a straight line, and no leg is better than that.
    pub fn excess(&self, path: &[Point]) -> f64 {
        let straight = distance(path[0], path[path.len() - 1]);
        self.cost(path) / straight.max(f64::MIN_POSITIVE)
    }
}
