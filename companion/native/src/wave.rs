//! A search that spreads over a lattice, cell by cell, from what it was started with: the part that A*, Dijkstra's search
//! and the search from both ends share.
//!
//! Cells wait in buckets one spacing wide (Dial 1969): no edge is shorter than that, so order within a bucket does not
//! matter to Dijkstra's search; to A* it costs a few cells that are looked at twice.

use crate::field::Field;
use crate::geometry::Point;
use crate::lattice::{Lattice, NEIGHBOURS};

/// What a search remembers of a cell: not met, met from a source itself, or through which neighbour's step.
const UNSEEN: u8 = 0;
const ENTRY: u8 = 1;
const FIRST_DIRECTION: u8 = 2;
/// Set beside these where the search can end.
const END: u8 = 0x80;
/// Spacings by which the last link, a straight line, may be shorter than steps over the lattice.
const SLACK: f64 = 0.25;

/// The shortest way over a lattice without obstacles.
pub fn octile(a: Point, b: Point) -> f64 {
    let (dx, dy) = ((b.x - a.x).abs(), (b.y - a.y).abs());
    dx.max(dy) + (std::f64::consts::SQRT_2 - 1.0) * dx.min(dy)
}

/// What a search writes on cells. It is wiped after each, so that the next one does not pay for a whole map.
#[derive(Default)]
pub struct Marks {
    cost: Vec<f64>,
    state: Vec<u8>,
    touched: Vec<u32>,
    /// Cells waiting to be looked at, with their cost when they were put in.
    buckets: Vec<Vec<(f64, u32)>>,
}

impl Marks {
    pub fn new(cells: usize) -> Self {
        // Zeroed pages cost nothing until they are touched: of a large map mostly few are.
        Self {
            cost: vec![0.0; cells],
            state: vec![UNSEEN; cells],
            touched: Vec::new(),
            buckets: Vec::new(),
        }
    }

    fn set(&mut self, index: usize, cost: f64, state: u8) {
        if self.state[index] == UNSEEN {
            self.touched.push(index as u32);
        }
        self.cost[index] = cost;
        self.state[index] = state;
    }

    /// True when the search has come to this cell.
    pub fn has(&self, index: usize) -> bool {
        self.state[index] & !END != UNSEEN
    }

    pub fn wipe(&mut self) {
        for index in self.touched.drain(..) {
            self.state[index as usize] = UNSEEN;
        }
        for bucket in &mut self.buckets {
            bucket.clear();
        }
    }
}

pub struct Wave {
    marks: Marks,
    towards: Option<Point>,
    /// The least key there can be.
    zero: f64,
    width: f64,
    /// The bucket that is being emptied.
    at: usize,
}

impl Wave {
    /// `towards` is where the search is headed; `least` is a lower bound of what a whole way costs.
    pub fn new(lattice: &mut Lattice, towards: Option<Point>, least: f64) -> Self {
        Self {
            marks: lattice.take_marks(),
            towards,
            zero: least - 4.0 * lattice.spacing,
            width: lattice.spacing,
            at: 0,
        }
    }

    /// Gives the lattice back what the search has used.
    pub fn end(mut self, lattice: &mut Lattice) {
        self.marks.wipe();
        lattice.give_marks(self.marks);
    }

    /// The same for a search that has seen all that it could: what it has seen is a piece of ground of its own.
    pub fn end_as_piece(self, lattice: &mut Lattice) {
        lattice.pieces.push(self.marks);
    }

    fn push(&mut self, index: usize, p: Point, cost: f64) {
        let ahead = self
            .towards
            .map_or(0.0, |goal| octile(p, goal) - SLACK * self.width);
        let key = (cost + ahead - self.zero).max(0.0);
        let bucket = ((key / self.width) as usize).max(self.at);
        let buckets = &mut self.marks.buckets;
        if bucket >= buckets.len() {
            buckets.resize_with(bucket + 1, Vec::new);
        }
        buckets[bucket].push((cost, index as u32));
    }

    /// Begins at a cell as well, unless it is known to cost less there; true when that was taken.
    pub fn enter(&mut self, lattice: &Lattice, index: usize, cost: f64) -> bool {
        let state = self.marks.state[index];
        if state & !END != UNSEEN && self.marks.cost[index] <= cost {
            return false;
        }
        self.marks.set(index, cost, (state & END) | ENTRY);
        self.push(index, lattice.point(index), cost);
        true
    }

    /// The search can end at this cell.
    pub fn end_at(&mut self, index: usize) {
        let (cost, state) = (self.marks.cost[index], self.marks.state[index]);
        self.marks.set(index, cost, state | END);
    }

    pub fn ends_at(&self, index: usize) -> bool {
        self.marks.state[index] & END != 0
    }

    /// True when the search has come to this cell.
    pub fn has(&self, index: usize) -> bool {
        self.marks.has(index)
    }

    /// The next cell to look at, with its cost.
    pub fn next(&mut self) -> Option<(f64, usize)> {
        while self.at < self.marks.buckets.len() {
            while let Some((cost, index)) = self.marks.buckets[self.at].pop() {
                if cost <= self.marks.cost[index as usize] {
                    return Some((cost, index as usize));
                }
            }
            self.at += 1;
        }
        None
    }

    /// No way that is still to be found costs less.
    pub fn least(&self) -> f64 {
        self.at as f64 * self.width + self.zero
    }

    /// Puts in the neighbours that the cell leads to.
    pub fn spread<F: Field>(&mut self, lattice: &mut Lattice, field: &F, cost: f64, index: usize) {
        let (column, row) = lattice.place(index);
        let room = lattice.room(field, index);
        for (direction, (across, up)) in NEIGHBOURS.into_iter().enumerate() {
            let (x, y) = (column + across, row + up);
            let Some(next) = lattice.index(x, y) else {
                continue;
            };
            let slanting = direction >= 4;
            let step = if slanting {
                std::f64::consts::SQRT_2 * self.width
            } else {
                self.width
            };
            let new = cost + step;
            let known = self.marks.state[next];
            if (known & !END == UNSEEN || new < self.marks.cost[next] - 1e-12)
                && lattice.edge_clear(field, (index, room), next, slanting)
            {
                let state = (known & END) | (FIRST_DIRECTION + direction as u8);
                self.marks.set(next, new, state);
                self.push(next, lattice.at(x, y), new);
            }
        }
    }

    /// What it costs to come to this cell, as far as the search knows.
    pub fn cost(&self, index: usize) -> f64 {
        self.marks.cost[index]
    }

    /// The cell from which the search came to this one; none where it came in.
    pub fn before(&self, lattice: &Lattice, index: usize) -> Option<usize> {
        let direction = (self.marks.state[index] & !END).checked_sub(FIRST_DIRECTION)?;
        let (across, up) = NEIGHBOURS[direction as usize];
        Some((index as i64 - across - up * lattice.columns as i64) as usize)
    }

    /// The cells from the one where the search came in to `end`.
    pub fn trace(&self, lattice: &Lattice, end: usize) -> Vec<usize> {
        let mut cells = vec![end];
        let mut at = end;
        while let Some(before) = self.before(lattice, at) {
            at = before;
            cells.push(at);
        }
        cells.reverse();
        cells
    }
}
