//! The map as a lattice of points: what a sampling planner can't do by itself. It proves goals unreachable, and finds a
//! way through ground where random samples seldom fall.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BinaryHeap};

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

/// What a search remembers of a cell: not met, met from the start itself, or through which neighbour's step.
const UNSEEN: u8 = 0;
const ENTRY: u8 = 1;
const FIRST_DIRECTION: u8 = 2;
const CLOSED: u8 = 0x80;

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
    pub fn new<F: Field>(field: &F, spacing: f64) -> Self {
        let (low, high) = field.bounds();
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

    /// Shortest ways over the cells' centres with exact edges: A* to one goal, Dijkstra's search to several at once.
    /// `late` is asked now and then whether to give up.
    pub fn paths<F: Field>(
        &self,
        field: &F,
        start: Point,
        goals: &[Point],
        radius: f64,
        late: impl Fn() -> bool,
    ) -> Vec<Option<Vec<Point>>> {
        let ahead = |p: Point| match goals {
            [goal] => distance(p, *goal),
            _ => 0.0,
        };
        // Zeroed pages cost nothing until they are touched: of a large map mostly few are.
        let mut cost = vec![0.0f64; self.size()];
        let mut state = vec![UNSEEN; self.size()];
        let mut heap = BinaryHeap::new();
        for (index, length) in self.links(field, start, radius) {
            cost[index] = length;
            state[index] = ENTRY;
            heap.push(Entry {
                key: length + ahead(self.point(index)),
                index,
            });
        }
        let mut ends: BTreeMap<usize, Vec<(usize, f64)>> = BTreeMap::new();
        for (goal, &p) in goals.iter().enumerate() {
            for (index, length) in self.links(field, p, radius) {
                ends.entry(index).or_default().push((goal, length));
            }
        }
        let mut best = vec![(f64::INFINITY, usize::MAX); goals.len()];
        let mut expanded = 0usize;
        while let Some(Entry { key, index }) = heap.pop() {
            if best.iter().all(|&(length, _)| key >= length) {
                break;
            }
            if state[index] & CLOSED != 0 {
                continue;
            }
            state[index] |= CLOSED;
            expanded += 1;
            if expanded.is_multiple_of(1024) && late() {
                return vec![None; goals.len()];
            }
            for &(goal, length) in ends.get(&index).map_or(&[][..], |list| list) {
                if cost[index] + length < best[goal].0 {
                    best[goal] = (cost[index] + length, index);
                }
            }
            let here = self.point(index);
            for (direction, &by) in NEIGHBOURS.iter().enumerate() {
                let Some(next) = self.step(index, by) else {
                    continue;
                };
                if state[next] & CLOSED != 0 {
                    continue;
                }
                let there = self.point(next);
                let new = cost[index] + distance(here, there);
                if (state[next] == UNSEEN || new < cost[next] - 1e-12)
                    && field.segment_clear(here, there, radius)
                {
                    cost[next] = new;
                    state[next] = FIRST_DIRECTION + direction as u8;
                    heap.push(Entry {
                        key: new + ahead(there),
                        index: next,
                    });
                }
            }
        }
        best.iter()
            .zip(goals)
            .map(|(&(_, end), &goal)| {
                (end != usize::MAX).then(|| self.trace(&state, start, end, goal))
            })
            .collect()
    }

    fn trace(&self, state: &[u8], start: Point, end: usize, goal: Point) -> Vec<Point> {
        let mut path = vec![goal, self.point(end)];
        let mut at = end;
        while state[at] & !CLOSED != ENTRY {
            let (across, up) = NEIGHBOURS[((state[at] & !CLOSED) - FIRST_DIRECTION) as usize];
            at = (at as i64 - across - up * self.columns as i64) as usize;
            path.push(self.point(at));
        }
        path.push(start);
        path.reverse();
        path
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

/// What the lattices know about the way to each goal: `Err(true)` stands for none found though it may exist, and
/// `Err(false)` for proof that there is none. Coarse lattices first; only the finest one's flood proves anything.
pub fn ways<F: Field>(
    field: &F,
    start: Point,
    goals: &[Point],
    radius: f64,
) -> Vec<Result<Vec<Point>, bool>> {
    let mut found: Vec<Result<Vec<Point>, bool>> = vec![Err(true); goals.len()];
    let spacings = field.lattice_spacings();
    for (level, &spacing) in spacings.iter().enumerate() {
        let lattice = Lattice::new(field, spacing);
        let mut open: Vec<usize> = (0..goals.len()).filter(|&g| found[g].is_err()).collect();
        if level + 1 == spacings.len() && !open.is_empty() {
            let asked: Vec<Point> = open.iter().map(|&g| goals[g]).collect();
            let possible = lattice.possible(field, start, &asked, radius);
            for (&goal, possible) in open.iter().zip(possible) {
                found[goal] = Err(possible);
            }
            open.retain(|&goal| found[goal] == Err(true));
        }
        if open.is_empty() {
            continue;
        }
        let asked: Vec<Point> = open.iter().map(|&g| goals[g]).collect();
        for (goal, way) in open
            .into_iter()
            .zip(lattice.paths(field, start, &asked, radius, || false))
        {
            if let Some(way) = way {
                found[goal] = Ok(way);
            }
        }
    }
    found
}
