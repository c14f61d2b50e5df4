//! The frontier of a search over a lattice: the part that A*, Dijkstra's search and the bidirectional search share.
//!
//! Cells wait in buckets one spacing wide (Dial 1969). No edge is shorter than that, so the order within a bucket does
//! not matter to Dijkstra's search; A* expands a few cells twice.

use crate::geometry::Point;
use crate::lattice::graph::{Lattice, FIRST_DIAGONAL, NEIGHBOURS};
use crate::lattice::labels::{Labels, FIRST_DIRECTION, SOURCE, TARGET, UNREACHED};
use crate::map::field::Field;

/// Spacings by which the last link, a straight line, may be shorter than the steps over the lattice that it replaces.
const LINK_SLACK: f64 = 0.25;
/// Spacings below a whole path's bound at which the first bucket begins: links may make a path that much shorter.
const FIRST_BUCKET: f64 = 4.0;
/// Metres that a new label must save, against loops of rounding.
const MIN_GAIN_M: f64 = 1e-12;

/// Length of the shortest 8-connected path where nothing is in the way.
pub fn octile(a: Point, b: Point) -> f64 {
    let (dx, dy) = ((b.x - a.x).abs(), (b.y - a.y).abs());
    dx.max(dy) + (std::f64::consts::SQRT_2 - 1.0) * dx.min(dy)
}

/// A search in progress.
pub struct Frontier {
    labels: Labels,
    towards: Option<Point>,
    /// The key at which the first bucket begins.
    zero: f64,
    width: f64,
    /// The bucket that is being emptied.
    at: usize,
}

impl Frontier {
    /// `towards`: the target of A*, none for Dijkstra's search; `least`: a lower bound of a whole path's cost.
    pub fn new(lattice: &mut Lattice, towards: Option<Point>, least: f64) -> Self {
        Self {
            labels: lattice.take_labels(),
            towards,
            zero: least - FIRST_BUCKET * lattice.spacing,
            width: lattice.spacing,
            at: 0,
        }
    }

    /// Gives the lattice its labels back.
    pub fn release(mut self, lattice: &mut Lattice) {
        self.labels.wipe();
        lattice.give_labels(self.labels);
    }

    /// The same for a search that has exhausted what it can reach: that is a connected component.
    pub fn release_component(self, lattice: &mut Lattice) {
        lattice.components.push(self.labels);
    }

    fn push(&mut self, index: usize, p: Point, cost: f64) {
        let ahead = self
            .towards
            .map_or(0.0, |goal| octile(p, goal) - LINK_SLACK * self.width);
        let key = (cost + ahead - self.zero).max(0.0);
        let bucket = ((key / self.width) as usize).max(self.at);
        let buckets = &mut self.labels.buckets;
        if bucket >= buckets.len() {
            buckets.resize_with(bucket + 1, Vec::new);
        }
        buckets[bucket].push((cost, index as u32));
    }

    /// Makes a cell a source, unless it is known to cost less already; true when it was taken.
    pub fn add_source(&mut self, lattice: &Lattice, index: usize, cost: f64) -> bool {
        let state = self.labels.state[index];
        if state & !TARGET != UNREACHED && self.labels.cost[index] <= cost {
            return false;
        }
        self.labels.set(index, cost, (state & TARGET) | SOURCE);
        self.push(index, lattice.point(index), cost);
        true
    }

    /// The search may end at this cell.
    pub fn mark_target(&mut self, index: usize) {
        let (cost, state) = (self.labels.cost[index], self.labels.state[index]);
        self.labels.set(index, cost, state | TARGET);
    }

    /// True when the search may end at this cell.
    pub fn is_target(&self, index: usize) -> bool {
        self.labels.state[index] & TARGET != 0
    }

    /// True when the search has reached this cell.
    pub fn reached(&self, index: usize) -> bool {
        self.labels.reached(index)
    }

    /// The next cell to expand, with its cost.
    pub fn pop(&mut self) -> Option<(f64, usize)> {
        while self.at < self.labels.buckets.len() {
            while let Some((cost, index)) = self.labels.buckets[self.at].pop() {
                if cost <= self.labels.cost[index as usize] {
                    return Some((cost, index as usize));
                }
            }
            self.at += 1;
        }
        None
    }

    /// A lower bound of the cost of every path still to be found.
    pub fn lower_bound(&self) -> f64 {
        self.at as f64 * self.width + self.zero
    }

    /// Labels the neighbours to which the cell has a clear edge.
    pub fn expand<F: Field>(&mut self, lattice: &mut Lattice, field: &F, cost: f64, index: usize) {
        let (column, row) = lattice.place(index);
        let clearance = lattice.clearance(field, index);
        for (direction, (across, up)) in NEIGHBOURS.into_iter().enumerate() {
            let (x, y) = (column + across, row + up);
            let Some(next) = lattice.index(x, y) else {
                continue;
            };
            let diagonal = direction >= FIRST_DIAGONAL;
            let step = if diagonal {
                std::f64::consts::SQRT_2 * self.width
            } else {
                self.width
            };
            let new = cost + step;
            let known = self.labels.state[next];
            if (known & !TARGET == UNREACHED || new < self.labels.cost[next] - MIN_GAIN_M)
                && lattice.edge_clear(field, (index, clearance), next, diagonal)
            {
                let state = (known & TARGET) | (FIRST_DIRECTION + direction as u8);
                self.labels.set(next, new, state);
                self.push(next, lattice.at(x, y), new);
            }
        }
    }

    /// The cost of a reached cell, as far as the search knows.
    pub fn cost(&self, index: usize) -> f64 {
        self.labels.cost[index]
    }

    /// The cell through which this one was reached; none for a source.
    pub fn parent(&self, lattice: &Lattice, index: usize) -> Option<usize> {
        let direction = (self.labels.state[index] & !TARGET).checked_sub(FIRST_DIRECTION)?;
        let (across, up) = NEIGHBOURS[direction as usize];
        Some((index as i64 - across - up * lattice.columns as i64) as usize)
    }

    /// The cells from a source to `end`.
    pub fn path_to(&self, lattice: &Lattice, end: usize) -> Vec<usize> {
        let mut cells = vec![end];
        let mut at = end;
        while let Some(parent) = self.parent(lattice, at) {
            at = parent;
            cells.push(at);
        }
        cells.reverse();
        cells
    }
}
