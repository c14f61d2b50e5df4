//! Shortest ways over a lattice: A* to one goal, Dijkstra's search to several at once.
//!
//! Cells wait in buckets one spacing wide (Dial 1969): no edge is shorter than that, so order within a bucket does not
//! matter to Dijkstra's search; to A* it costs a few cells that are looked at twice.

use std::collections::BTreeMap;

use crate::field::Field;
use crate::geometry::{distance, Point};
use crate::lattice::{Lattice, NEIGHBOURS};

/// What a search remembers of a cell: not met, met from the start itself, or through which neighbour's step.
const UNSEEN: u8 = 0;
const ENTRY: u8 = 1;
const FIRST_DIRECTION: u8 = 2;
/// Set beside these where a goal can be entered from.
const END: u8 = 0x80;

/// Cells waiting to be looked at, with their cost when they were put in.
struct Queue {
    buckets: Vec<Vec<(f64, u32)>>,
    width: f64,
    at: usize,
}

impl Queue {
    fn push(&mut self, key: f64, cost: f64, index: usize) {
        let bucket = ((key / self.width) as usize).max(self.at);
        if bucket >= self.buckets.len() {
            self.buckets.resize_with(bucket + 1, Vec::new);
        }
        self.buckets[bucket].push((cost, index as u32));
    }

    fn pop(&mut self) -> Option<(f64, usize)> {
        while self.at < self.buckets.len() {
            if let Some((cost, index)) = self.buckets[self.at].pop() {
                return Some((cost, index as usize));
            }
            self.buckets[self.at] = Vec::new();
            self.at += 1;
        }
        None
    }

    /// No key still waiting is smaller.
    fn least(&self) -> f64 {
        self.at as f64 * self.width
    }
}

/// The way from `start` to each goal, with exact edges; none where the lattice has none. `late` is asked now and
/// then whether to give up.
pub fn paths<F: Field>(
    lattice: &mut Lattice,
    field: &F,
    start: Point,
    goals: &[Point],
    late: impl Fn() -> bool,
) -> Vec<Option<Vec<Point>>> {
    let ahead = |p: Point| match goals {
        [goal] => distance(p, *goal),
        _ => 0.0,
    };
    // Zeroed pages cost nothing until they are touched: of a large map mostly few are.
    let mut cost = vec![0.0f64; lattice.size()];
    let mut state = vec![UNSEEN; lattice.size()];
    let mut queue = Queue {
        buckets: Vec::new(),
        width: lattice.spacing,
        at: 0,
    };
    for (index, length) in lattice.links(field, start) {
        cost[index] = length;
        state[index] = ENTRY;
        queue.push(length + ahead(lattice.point(index)), length, index);
    }
    let mut ends: BTreeMap<usize, Vec<(usize, f64)>> = BTreeMap::new();
    for (goal, &p) in goals.iter().enumerate() {
        for (index, length) in lattice.links(field, p) {
            ends.entry(index).or_default().push((goal, length));
            state[index] |= END;
        }
    }
    let mut best = vec![(f64::INFINITY, usize::MAX); goals.len()];
    let mut farthest = f64::INFINITY;
    let mut expanded = 0usize;
    let spans = [lattice.spacing, std::f64::consts::SQRT_2 * lattice.spacing];
    while let Some((here_cost, index)) = queue.pop() {
        if queue.least() >= farthest {
            break;
        }
        if here_cost > cost[index] {
            continue;
        }
        expanded += 1;
        if expanded.is_multiple_of(1024) && late() {
            return vec![None; goals.len()];
        }
        if state[index] & END != 0 {
            for &(goal, length) in &ends[&index] {
                if here_cost + length < best[goal].0 {
                    best[goal] = (here_cost + length, index);
                }
            }
            farthest = best.iter().fold(0.0, |most, &(length, _)| most.max(length));
        }
        for (direction, next) in lattice.around(index).into_iter().enumerate() {
            let Some(next) = next else {
                continue;
            };
            let slanting = direction >= 4;
            let new = here_cost + spans[usize::from(slanting)];
            let known = state[next];
            if (known & !END == UNSEEN || new < cost[next] - 1e-12)
                && lattice.edge_clear(field, index, next, slanting)
            {
                cost[next] = new;
                state[next] = (known & END) | (FIRST_DIRECTION + direction as u8);
                queue.push(new + ahead(lattice.point(next)), new, next);
            }
        }
    }
    best.iter()
        .zip(goals)
        .map(|(&(_, end), &goal)| {
            (end != usize::MAX).then(|| trace(lattice, &state, start, end, goal))
        })
        .collect()
}

fn trace(lattice: &Lattice, state: &[u8], start: Point, end: usize, goal: Point) -> Vec<Point> {
    let mut path = vec![goal, lattice.point(end)];
    let mut at = end;
    while state[at] & !END != ENTRY {
        let (across, up) = NEIGHBOURS[((state[at] & !END) - FIRST_DIRECTION) as usize];
        at = (at as i64 - across - up * lattice.columns as i64) as usize;
        path.push(lattice.point(at));
    }
    path.push(start);
    path.reverse();
    path
}
