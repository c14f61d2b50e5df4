//! The map as a lattice of points: what a sampling planner can't do by itself. It proves goals unreachable, and finds a
//! way through ground where random samples seldom fall.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use crate::field::Field;
use crate::geometry::{distance, Point};

pub struct Lattice {
    columns: usize,
    rows: usize,
    low: Point,
    spacing: f64,
}

/// Heap entry: the smallest key first, of equals the lower index.
pub struct Entry {
    pub key: f64,
    pub index: usize,
}

impl PartialEq for Entry {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Entry {}
impl PartialOrd for Entry {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Entry {
    fn cmp(&self, other: &Self) -> Ordering {
        other
            .key
            .total_cmp(&self.key)
            .then_with(|| other.index.cmp(&self.index))
    }
}

pub const NEIGHBOURS: [(i64, i64); 8] = [
    (1, 0),
    (0, 1),
    (-1, 0),
    (0, -1),
    (1, 1),
    (-1, 1),
    (-1, -1),
    (1, -1),
];

impl Lattice {
    pub fn new<F: Field>(field: &F) -> Self {
        let (low, high) = field.bounds();
        let spacing = field.lattice_spacing();
        Self {
            columns: ((high.x - low.x) / spacing).round().max(1.0) as usize,
            rows: ((high.y - low.y) / spacing).round().max(1.0) as usize,
            low,
            spacing,
        }
    }

    pub fn size(&self) -> usize {
        self.columns * self.rows
    }

    fn point(&self, index: usize) -> Point {
        Point::new(
            self.low.x + ((index % self.columns) as f64 + 0.5) * self.spacing,
            self.low.y + ((index / self.columns) as f64 + 0.5) * self.spacing,
        )
    }

    fn cell(&self, p: Point) -> (i64, i64) {
        let column = ((p.x - self.low.x) / self.spacing).floor() as i64;
        let row = ((p.y - self.low.y) / self.spacing).floor() as i64;
        (
            column.clamp(0, self.columns as i64 - 1),
            row.clamp(0, self.rows as i64 - 1),
        )
    }

    fn index(&self, column: i64, row: i64) -> Option<usize> {
        (column >= 0 && row >= 0 && column < self.columns as i64 && row < self.rows as i64)
            .then(|| row as usize * self.columns + column as usize)
    }

    fn step(&self, index: usize, by: (i64, i64)) -> Option<usize> {
        let (column, row) = ((index % self.columns) as i64, (index / self.columns) as i64);
        self.index(column + by.0, row + by.1)
    }

    /// For each goal, false when it certainly can't be reached: a flood over every cell that could hold any
    /// position of the robot at all does not get there.
    pub fn possible<F: Field>(
        &self,
        field: &F,
        start: Point,
        goals: &[Point],
        radius: f64,
    ) -> Vec<bool> {
        let half_diagonal = 0.7072 * self.spacing;
        let mut flooded = vec![false; self.size()];
        let (column, row) = self.cell(start);
        let mut pending = Vec::new();
        pending.extend(self.index(column, row));
        for &index in &pending {
            flooded[index] = true;
        }
        while let Some(at) = pending.pop() {
            for by in NEIGHBOURS {
                let Some(next) = self.step(at, by) else {
                    continue;
                };
                // Clearance is 1-Lipschitz: no point of a cell has more than its centre's plus the half diagonal.
                if !flooded[next] && field.clearance(self.point(next)) + half_diagonal >= radius {
                    flooded[next] = true;
                    pending.push(next);
                }
            }
        }
        goals
            .iter()
            .map(|&goal| {
                let (column, row) = self.cell(goal);
                self.index(column, row).is_some_and(|index| flooded[index])
            })
            .collect()
    }

    /// A* over the cells' centres with exact edges. `late` is asked now and then whether to give up.
    pub fn path<F: Field>(
        &self,
        field: &F,
        start: Point,
        goal: Point,
        radius: f64,
        late: impl Fn() -> bool,
    ) -> Option<Vec<Point>> {
        let mut cost = vec![f64::INFINITY; self.size()];
        let mut from = vec![usize::MAX; self.size()];
        let mut closed = vec![false; self.size()];
        let mut heap = BinaryHeap::new();
        for (index, length) in self.links(field, start, radius) {
            cost[index] = length;
            heap.push(Entry {
                key: length + distance(self.point(index), goal),
                index,
            });
        }
        let mut last_links = vec![f64::INFINITY; self.size()];
        let ends = self.links(field, goal, radius);
        for &(index, length) in &ends {
            last_links[index] = length;
        }
        let mut best: (f64, usize) = (f64::INFINITY, usize::MAX);
        let mut expanded = 0usize;
        while let Some(Entry { key, index }) = heap.pop() {
            if key >= best.0 {
                break;
            }
            if closed[index] {
                continue;
            }
            closed[index] = true;
            expanded += 1;
            if expanded.is_multiple_of(1024) && late() {
                return None;
            }
            let through = cost[index] + last_links[index];
            if through < best.0 {
                best = (through, index);
            }
            let here = self.point(index);
            for by in NEIGHBOURS {
                let Some(next) = self.step(index, by) else {
                    continue;
                };
                let there = self.point(next);
                let new = cost[index] + distance(here, there);
                if !closed[next]
                    && new < cost[next] - 1e-12
                    && field.segment_clear(here, there, radius)
                {
                    cost[next] = new;
                    from[next] = index;
                    heap.push(Entry {
                        key: new + distance(there, goal),
                        index: next,
                    });
                }
            }
        }
        if best.1 == usize::MAX {
            return None;
        }
        let mut path = vec![goal];
        let mut at = best.1;
        while at != usize::MAX {
            path.push(self.point(at));
            at = from[at];
        }
        path.push(start);
        path.reverse();
        Some(path)
    }

    /// Cells around `p` that a straight edge reaches, with its length.
    fn links<F: Field>(&self, field: &F, p: Point, radius: f64) -> Vec<(usize, f64)> {
        let (column, row) = self.cell(p);
        let mut links = Vec::new();
        for down in -2..=2 {
            for across in -2..=2 {
                if let Some(index) = self.index(column + across, row + down) {
                    let centre = self.point(index);
                    if field.segment_clear(p, centre, radius) {
                        links.push((index, distance(p, centre)));
                    }
                }
            }
        }
        links
    }
}
