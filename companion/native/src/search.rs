//! Shortest ways over a lattice: A* to one goal, Dijkstra's search to several at once, and short ways between two lines,
//! searched from both.

use std::collections::BTreeMap;

use crate::field::Field;
use crate::geometry::Point;
use crate::lattice::Lattice;
use crate::wave::{octile, Wave};

/// The way from `start` to each goal, with exact edges; none where the lattice has none. `late` is asked now and
/// then whether to give up.
pub fn paths<F: Field>(
    lattice: &mut Lattice,
    field: &F,
    start: Point,
    goals: &[Point],
    late: impl Fn() -> bool,
) -> Vec<Option<Vec<Point>>> {
    let (towards, least) = match goals {
        [goal] => (Some(*goal), octile(start, *goal)),
        _ => (None, 0.0),
    };
    let mut wave = Wave::new(lattice, towards, least);
    for (index, length) in lattice.links(field, start, 2) {
        wave.enter(lattice, index, length);
    }
    let mut ends: BTreeMap<usize, Vec<(usize, f64)>> = BTreeMap::new();
    for (goal, &p) in goals.iter().enumerate() {
        for (index, length) in lattice.links(field, p, 2) {
            ends.entry(index).or_default().push((goal, length));
            wave.end_at(index);
        }
    }
    let mut best = vec![(f64::INFINITY, usize::MAX); goals.len()];
    let mut farthest = f64::INFINITY;
    let mut looked = 0usize;
    while let Some((cost, index)) = wave.next() {
        if wave.least() >= farthest {
            break;
        }
        looked += 1;
        if looked.is_multiple_of(1024) && late() {
            best.fill((f64::INFINITY, usize::MAX));
            break;
        }
        if wave.ends_at(index) {
            for &(goal, length) in &ends[&index] {
                if cost + length < best[goal].0 {
                    best[goal] = (cost + length, index);
                }
            }
            farthest = best.iter().fold(0.0, |most, &(length, _)| most.max(length));
        }
        wave.spread(lattice, field, cost, index);
    }
    let way = |end: usize, goal: Point| {
        let inner = corners(lattice, wave.trace(lattice, end));
        [start].into_iter().chain(inner).chain([goal]).collect()
    };
    let found = best
        .iter()
        .zip(goals)
        .map(|(&(_, end), &goal)| (end != usize::MAX).then(|| way(end, goal)))
        .collect();
    wave.end(lattice);
    found
}

/// The ends of a way over cells, and where it turns.
pub fn corners(lattice: &Lattice, cells: Vec<usize>) -> Vec<Point> {
    let step = |index: usize| cells[index + 1] as i64 - cells[index] as i64;
    let last = cells.len() - 1;
    (0..=last)
        .filter(|&index| index == 0 || index == last || step(index) != step(index - 1))
        .map(|index| lattice.point(cells[index]))
        .collect()
}

/// A point of a line between which and another line a way is looked for.
pub struct Stop {
    pub p: Point,
    /// The number of the line's vertex that comes after it.
    pub next: usize,
}

/// From the source and to the target of these numbers, with what lies between.
pub type Joint = (usize, usize, Vec<Point>);

/// A way with exact edges from one of the stops `behind` to one of those `ahead`: two searches head for each other, and
/// the first way on which they meet is taken. None where one of them has seen all that it can reach: that is known when
/// the smaller side is exhausted.
pub fn joint<F: Field>(
    lattice: &mut Lattice,
    field: &F,
    behind: &[Stop],
    ahead: &[Stop],
) -> Option<Joint> {
    let sides = [behind, ahead];
    let mut entries = [BTreeMap::new(), BTreeMap::new()];
    let mut waves = [0, 1].map(|side| {
        let radius = lattice.radius;
        let others = sides[1 - side];
        let near = others.iter().find(|stop| field.point_clear(stop.p, radius));
        let towards = near.unwrap_or(&others[0]).p;
        let least = (sides[side].iter())
            .map(|stop| octile(stop.p, towards))
            .fold(f64::INFINITY, f64::min);
        let mut wave = Wave::new(lattice, Some(towards), least);
        for (number, stop) in sides[side].iter().enumerate() {
            let reach = match number {
                0 => 1,
                _ if number + 1 == sides[side].len() => 2,
                _ => 0,
            };
            let links = lattice.links(field, stop.p, reach);
            for (index, length) in links {
                if wave.enter(lattice, index, length) {
                    entries[side].insert(index, number);
                }
            }
        }
        wave
    });
    let [here, there] = [0, 1].map(|side| entries[side].keys().copied().collect::<Vec<_>>());
    let (met, exhausted) = if lattice.apart(&here, &there) {
        (None, None)
    } else {
        match meeting(lattice, field, &mut waves) {
            Ok(cell) => (Some(cell), None),
            Err(side) => (None, Some(side)),
        }
    };
    let found = met.map(|cell| {
        let [out, back] = [0, 1].map(|side| waves[side].trace(lattice, cell));
        let (source, target) = (entries[0][&out[0]], entries[1][&back[0]]);
        let cells: Vec<usize> = out
            .into_iter()
            .chain(back.into_iter().rev().skip(1))
            .collect();
        (source, target, corners(lattice, cells))
    });
    for (side, wave) in waves.into_iter().enumerate() {
        if exhausted == Some(side) {
            wave.end_as_piece(lattice);
        } else {
            wave.end(lattice);
        }
    }
    found
}

/// The first cell on which two searches meet, or which of them has nowhere left to go.
fn meeting<F: Field>(
    lattice: &mut Lattice,
    field: &F,
    waves: &mut [Wave; 2],
) -> Result<usize, usize> {
    loop {
        for side in [0, 1] {
            let (cost, index) = waves[side].next().ok_or(side)?;
            if waves[1 - side].has(index) {
                return Ok(index);
            }
            waves[side].spread(lattice, field, cost, index);
        }
    }
}
