//! Builds a roadmap: nodes where clearance is largest, each with its Voronoi region on a lattice, and edges between
//! regions that touch. What the lattice connects, the roadmap connects.

use crate::geometry::{distance, Point};
use crate::lattice::a_star;
use crate::lattice::frontier::Frontier;
use crate::lattice::graph::{Lattice, FIRST_DIAGONAL, NEIGHBOURS};
use crate::map::field::Field;
use crate::path::simplify::{self, Simplification};
use crate::replan::roadmap::Roadmap;

/// Lattice spacings between nodes at least.
const MIN_SPACING: f64 = 8.0;
/// Nodes that cover the whole map, about.
const MAX_NODES: f64 = 16_000.0;
/// Cells of the lattice, unless the coarsest has more.
const MAX_CELLS: f64 = 1_000_000.0;
/// Edges between the same two nodes, on different sides of something.
const MAX_PARALLEL: usize = 2;
/// Sweeps of string pulling over each edge.
const SWEEPS: usize = 2;

/// Belongs to no node's region.
const NO_NODE: u32 = u32::MAX;

/// Where the regions of two nodes touch: the nodes, the length of the path from one to the other, and the cells.
type Border = ([u32; 2], f64, [usize; 2]);

/// The roadmap of `field` for a robot as in `settings`.
pub fn build<F: Field>(field: &F, settings: Simplification) -> Roadmap {
    let (low, high) = field.bounds();
    let area = (high.x - low.x) * (high.y - low.y);
    let spacings = field.lattice_spacings(settings.radius);
    let affordable = |&&spacing: &&f64| area <= MAX_CELLS * spacing * spacing;
    let spacing = spacings
        .iter()
        .rev()
        .find(affordable)
        .unwrap_or(&spacings[0]);
    let mut lattice = Lattice::new(field, *spacing, settings.radius);
    let apart = (MIN_SPACING * spacing).max((area / MAX_NODES).sqrt());
    let cells = node_cells(&mut lattice, field, apart);
    let mut frontier = Frontier::new(&mut lattice, None, 0.0);
    let mut owner = vec![NO_NODE; lattice.size()];
    for (node, &cell) in cells.iter().enumerate() {
        frontier.add_source(&lattice, cell, 0.0);
        owner[cell] = node as u32;
    }
    let mut borders: Vec<Border> = Vec::new();
    while let Some((cost, cell)) = frontier.pop() {
        if let Some(parent) = frontier.parent(&lattice, cell) {
            owner[cell] = owner[parent];
        }
        frontier.expand(&mut lattice, field, cost, cell);
        note_borders(&mut lattice, field, &frontier, &owner, cell, &mut borders);
    }
    borders.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
    let mut edges = Vec::new();
    for between in borders.chunk_by(|a, b| a.0 == b.0) {
        let mut taken: Vec<Point> = Vec::new();
        for (ends, _, touching) in between {
            let p = lattice.point(touching[0]);
            if taken.len() < MAX_PARALLEL && taken.iter().all(|&q| distance(p, q) > apart) {
                taken.push(p);
                edges.push((
                    *ends,
                    path_between(field, &lattice, &frontier, *touching, settings),
                ));
            }
        }
    }
    let points = cells.iter().map(|&cell| lattice.point(cell)).collect();
    Roadmap::new(points, edges, settings.radius, apart)
}

/// Cells for nodes, those with most clearance first, `apart` metres from each other.
fn node_cells<F: Field>(lattice: &mut Lattice, field: &F, apart: f64) -> Vec<usize> {
    let mut free: Vec<(f32, usize)> = (0..lattice.size())
        .map(|cell| (lattice.clearance(field, cell), cell))
        .filter(|&(clearance, _)| clearance > 0.0)
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

/// Notes where a cell that has just been settled touches settled cells of other regions.
fn note_borders<F: Field>(
    lattice: &mut Lattice,
    field: &F,
    frontier: &Frontier,
    owner: &[u32],
    cell: usize,
    borders: &mut Vec<Border>,
) {
    let (column, row) = lattice.place(cell);
    for (direction, (across, up)) in NEIGHBOURS.into_iter().enumerate() {
        let Some(neighbour) = lattice.index(column + across, row + up) else {
            continue;
        };
        let (own, other) = (owner[cell], owner[neighbour]);
        if other == NO_NODE || other == own {
            continue;
        }
        let clearance = lattice.clearance(field, cell);
        let diagonal = direction >= FIRST_DIAGONAL;
        if lattice.edge_clear(field, (cell, clearance), neighbour, diagonal) {
            let step = distance(lattice.point(cell), lattice.point(neighbour));
            let length = frontier.cost(cell) + step + frontier.cost(neighbour);
            if own < other {
                borders.push(([own, other], length, [cell, neighbour]));
            } else {
                borders.push(([other, own], length, [neighbour, cell]));
            }
        }
    }
}

/// What lies between two nodes whose regions touch in these cells.
fn path_between<F: Field>(
    field: &F,
    lattice: &Lattice,
    frontier: &Frontier,
    [here, there]: [usize; 2],
    settings: Simplification,
) -> Vec<Point> {
    let mut cells = frontier.path_to(lattice, here);
    cells.extend(frontier.path_to(lattice, there).into_iter().rev());
    let mut path = a_star::corners(lattice, cells);
    simplify::simplify(field, &mut path, settings, SWEEPS);
    path[1..path.len() - 1].to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::grid::Grid;
    use crate::path::simplify::LEAST_MOVE;
    use crate::replan::lazy_a_star;

    #[test]
    fn the_roadmap_connects_two_rooms_through_their_door() {
        let mut blocked = vec![0u8; 10_000];
        for row in (0..100).filter(|row| !(60..70).contains(row)) {
            blocked[100 * row + 50] = 1;
        }
        let field = Grid::new(blocked, 100, 100, 0.1, Point::new(0.0, 0.0));
        let settings = Simplification {
            radius: 0.2,
            corner_cost: 0.0,
            least_move: LEAST_MOVE,
            deadline: None,
        };
        let mut roadmap = build(&field, settings);
        let (from, to) = (
            roadmap.add_node(Point::new(1.0, 1.0)),
            roadmap.add_node(Point::new(9.0, 1.0)),
        );
        let found = lazy_a_star::search(&mut roadmap, &field, from, to).expect("the door is open");
        assert!(found
            .iter()
            .any(|&(node, _)| (roadmap.point(node).x - 5.0).abs() < 1.5));
        let (nodes, edges) = roadmap.size();
        assert!(nodes > 50 && edges > nodes);
    }
}
