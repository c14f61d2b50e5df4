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
/// Share of the spacing that a new label must save: more than costs are rounded by.
const MIN_GAIN: f64 = 1e-3;
/// Directions of `NEIGHBOURS`, as bits, in which a search goes on from an open cell that it has reached in each direction.
const NATURAL: [u8; 8] = [
    0b0000_0001, // right
    0b0000_0010, // up
    0b0000_0100, // left
    0b0000_1000, // down
    0b0001_0011, // up and right
    0b0010_0110, // up and left
    0b0100_1100, // down and left
    0b1000_1001, // down and right
];

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
    expanded: u64,
    /// Metres of a straight and of a diagonal step.
    steps: [f32; 2],
    /// Metres that a new label must save.
    min_gain: f32,
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
            expanded: 0,
            steps: [lattice.spacing, std::f64::consts::SQRT_2 * lattice.spacing].map(|s| s as f32),
            min_gain: (MIN_GAIN * lattice.spacing) as f32,
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

    fn push(&mut self, index: usize, p: Point, cost: f32) {
        let ahead = self
            .towards
            .map_or(0.0, |goal| octile(p, goal) - LINK_SLACK * self.width);
        let key = (f64::from(cost) + ahead - self.zero).max(0.0);
        let bucket = ((key / self.width) as usize).max(self.at);
        self.labels.push(bucket, index, cost);
    }

    /// Makes a cell a source, unless it is known to cost less already; true when it was taken.
    pub fn add_source(&mut self, lattice: &Lattice, index: usize, cost: f64) -> bool {
        let state = self.labels.state[index];
        if state & !TARGET != UNREACHED && self.labels.cost[index] <= cost as f32 {
            return false;
        }
        self.labels
            .set(index, cost as f32, (state & TARGET) | SOURCE);
        self.push(index, lattice.point(index), cost as f32);
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
        while self.at < self.labels.buckets() {
            while let Some((cost, index)) = self.labels.pop(self.at) {
                if cost <= self.labels.cost[index] {
                    self.expanded += 1;
                    return Some((f64::from(cost), index));
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

    /// Labels the neighbours to which the cell has a clear edge. Where all edges around it are clear, only those that no
    /// other shortest path replaces (the natural neighbours of jump point search, Harabor and Grastien 2011).
    pub fn expand<F: Field>(&mut self, lattice: &mut Lattice, field: &F, cost: f64, index: usize) {
        let edges = lattice.edges(field, index);
        let arrival = (self.labels.state[index] & !TARGET).checked_sub(FIRST_DIRECTION);
        let mut directions = match arrival {
            Some(arrival) if edges.all_around => NATURAL[arrival as usize],
            _ => edges.directions,
        };
        let (column, row) = lattice.place(index);
        while directions != 0 {
            let direction = directions.trailing_zeros() as usize;
            directions &= directions - 1;
            let diagonal = direction >= FIRST_DIAGONAL;
            let new = cost as f32 + self.steps[usize::from(diagonal)];
            let (across, up) = NEIGHBOURS[direction];
            let next = (index as i64 + across + up * lattice.columns as i64) as usize;
            let known = self.labels.state[next];
            if known & !TARGET == UNREACHED || new < self.labels.cost[next] - self.min_gain {
                let state = (known & TARGET) | (FIRST_DIRECTION + direction as u8);
                self.labels.set(next, new, state);
                self.push(next, lattice.at(column + across, row + up), new);
            }
        }
    }

    /// How many cells have been expanded.
    pub fn expanded(&self) -> u64 {
        self.expanded
    }

    /// How many cells have been labelled.
    pub fn labelled(&self) -> usize {
        self.labels.count()
    }

    /// The cost of a reached cell, as far as the search knows.
    pub fn cost(&self, index: usize) -> f64 {
        f64::from(self.labels.cost[index])
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
