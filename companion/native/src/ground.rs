//! A roadmap of the ground: nodes where there is most room, each with the part of a lattice that is nearest to it, and
//! edges between parts that touch. What a lattice connects, the roadmap connects.

use crate::field::Field;
use crate::geometry::{distance, Point};
use crate::lattice::{Lattice, NEIGHBOURS};
use crate::roadmap::Roadmap;
use crate::search;
use crate::shorten::{self, Shortening};
use crate::wave::Wave;

/// Lattice spacings between nodes at least.
const APART: f64 = 8.0;
/// Nodes that cover the whole field, about.
const MOST_NODES: f64 = 16_000.0;
/// Cells of the lattice, unless the coarsest has more.
const MOST_CELLS: f64 = 1_000_000.0;
/// Edges between the same two nodes, on different sides of something.
const BESIDE: usize = 2;

/// Belongs to no node.
const NOBODY: u32 = u32::MAX;

/// A place where the parts of two nodes touch: the nodes, the length of the way from one to the other, and the cells.
type Border = ([u32; 2], f64, [usize; 2]);

pub fn roadmap<F: Field>(field: &F, settings: Shortening) -> Roadmap {
    let (low, high) = field.bounds();
    let area = (high.x - low.x) * (high.y - low.y);
    let spacings = field.lattice_spacings(settings.radius);
    let affordable = |&&spacing: &&f64| area <= MOST_CELLS * spacing * spacing;
    let spacing = spacings
        .iter()
        .rev()
        .find(affordable)
        .unwrap_or(&spacings[0]);
    let mut lattice = Lattice::new(field, *spacing, settings.radius);
    let apart = (APART * spacing).max((area / MOST_NODES).sqrt());
    let cells = places(&mut lattice, field, apart);
    let mut wave = Wave::new(&mut lattice, None, 0.0);
    let mut owner = vec![NOBODY; lattice.size()];
    for (node, &cell) in cells.iter().enumerate() {
        wave.enter(&lattice, cell, 0.0);
        owner[cell] = node as u32;
    }
    let mut borders: Vec<Border> = Vec::new();
    while let Some((cost, cell)) = wave.next() {
        if let Some(before) = wave.before(&lattice, cell) {
            owner[cell] = owner[before];
        }
        wave.spread(&mut lattice, field, cost, cell);
        meet(&mut lattice, field, &wave, &owner, cell, &mut borders);
    }
    borders.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
    let mut edges = Vec::new();
    for between in borders.chunk_by(|a, b| a.0 == b.0) {
        let mut taken: Vec<Point> = Vec::new();
        for (ends, _, touching) in between {
            let p = lattice.point(touching[0]);
            if taken.len() < BESIDE && taken.iter().all(|&q| distance(p, q) > apart) {
                taken.push(p);
                edges.push((*ends, way(field, &lattice, &wave, *touching, settings)));
            }
        }
    }
    let points = cells.iter().map(|&cell| lattice.point(cell)).collect();
    Roadmap::new(points, edges, settings.radius, apart)
}

/// Cells for nodes, those with most room first, `apart` from each other.
fn places<F: Field>(lattice: &mut Lattice, field: &F, apart: f64) -> Vec<usize> {
    let mut free: Vec<(f32, usize)> = (0..lattice.size())
        .map(|cell| (lattice.room(field, cell), cell))
        .filter(|&(room, _)| room > 0.0)
        .collect();
    free.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let (low, high) = field.bounds();
    let columns = ((high.x - low.x) / apart) as usize + 1;
    let rows = ((high.y - low.y) / apart) as usize + 1;
    let mut taken: Vec<Vec<Point>> = vec![Vec::new(); columns * rows];
    let mut cells = Vec::new();
    for (_, cell) in free {
        let p = lattice.point(cell);
        let column = (((p.x - low.x) / apart) as usize).min(columns - 1);
        let row = (((p.y - low.y) / apart) as usize).min(rows - 1);
        let lines = row.saturating_sub(1)..=(row + 1).min(rows - 1);
        let near = lines.flat_map(|y| {
            let left = y * columns + column.saturating_sub(1);
            left..=y * columns + (column + 1).min(columns - 1)
        });
        if near
            .flat_map(|bucket| &taken[bucket])
            .all(|&q| distance(p, q) >= apart)
        {
            taken[row * columns + column].push(p);
            cells.push(cell);
        }
    }
    cells
}

/// Notes where a cell that has just been settled touches settled cells of other nodes.
fn meet<F: Field>(
    lattice: &mut Lattice,
    field: &F,
    wave: &Wave,
    owner: &[u32],
    cell: usize,
    borders: &mut Vec<Border>,
) {
    let (column, row) = lattice.place(cell);
    for (direction, (across, up)) in NEIGHBOURS.into_iter().enumerate() {
        let Some(beside) = lattice.index(column + across, row + up) else {
            continue;
        };
        let (own, other) = (owner[cell], owner[beside]);
        if other == NOBODY || other == own {
            continue;
        }
        let room = lattice.room(field, cell);
        if lattice.edge_clear(field, (cell, room), beside, direction >= 4) {
            let step = distance(lattice.point(cell), lattice.point(beside));
            let length = wave.cost(cell) + step + wave.cost(beside);
            if own < other {
                borders.push(([own, other], length, [cell, beside]));
            } else {
                borders.push(([other, own], length, [beside, cell]));
            }
        }
    }
}

/// What lies between two nodes whose parts touch in these cells.
fn way<F: Field>(
    field: &F,
    lattice: &Lattice,
    wave: &Wave,
    [here, there]: [usize; 2],
    settings: Shortening,
) -> Vec<Point> {
    let mut cells = wave.trace(lattice, here);
    cells.extend(wave.trace(lattice, there).into_iter().rev());
    let mut path = search::corners(lattice, cells);
    shorten::settle(field, &mut path, settings, 2);
    path[1..path.len() - 1].to_vec()
}
