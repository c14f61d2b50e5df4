//! Bidirectional search over a lattice: short paths between two sets of points.

use std::collections::BTreeMap;

use crate::geometry::Point;
use crate::lattice::a_star::corners;
use crate::lattice::frontier::{octile, Frontier};
use crate::lattice::graph::Lattice;
use crate::map::field::Field;

/// Columns and rows from the first terminal's cell to those that it is linked to.
const FIRST_REACH: i64 = 1;
/// The same for the last one; terminals between are linked to their own cell alone.
const LAST_REACH: i64 = 2;

/// A point at which the search may begin or end.
pub struct Terminal {
    /// Where it is.
    pub p: Point,
    /// The caller's number: of the vertex of a path that comes after the point, or of a tree's node.
    pub next: usize,
}

/// A path between two terminals.
pub struct Connection {
    /// Index of the terminal among the sources.
    pub source: usize,
    /// Index of the terminal among the targets.
    pub target: usize,
    /// What lies between them.
    pub inner: Vec<Point>,
}

/// A path with exact edges from one of the `sources` to one of the `targets`: two searches head for each other, and the
/// first path on which they meet is taken. None when one of them has exhausted what it can reach.
pub fn search<F: Field>(
    lattice: &mut Lattice,
    field: &F,
    sources: &[Terminal],
    targets: &[Terminal],
) -> Option<Connection> {
    let sides = [sources, targets];
    let mut entries = [BTreeMap::new(), BTreeMap::new()];
    let mut frontiers = [0, 1].map(|side| {
        let radius = lattice.radius;
        let others = sides[1 - side];
        let near = (others.iter()).find(|terminal| field.point_clear(terminal.p, radius));
        let towards = near.unwrap_or(&others[0]).p;
        let least = (sides[side].iter())
            .map(|terminal| octile(terminal.p, towards))
            .fold(f64::INFINITY, f64::min);
        let mut frontier = Frontier::new(lattice, Some(towards), least);
        for (number, terminal) in sides[side].iter().enumerate() {
            let reach = match number {
                0 => FIRST_REACH,
                _ if number + 1 == sides[side].len() => LAST_REACH,
                _ => 0,
            };
            let links = lattice.links(field, terminal.p, reach);
            for (index, length) in links {
                if frontier.add_source(lattice, index, length) {
                    entries[side].insert(index, number);
                }
            }
        }
        frontier
    });
    let [here, there] = [0, 1].map(|side| entries[side].keys().copied().collect::<Vec<_>>());
    let (met, exhausted) = if lattice.known_disconnected(&here, &there) {
        (None, None)
    } else {
        match meeting(lattice, field, &mut frontiers) {
            Ok(cell) => (Some(cell), None),
            Err(side) => (None, Some(side)),
        }
    };
    let found = met.map(|cell| {
        let [out, back] = [0, 1].map(|side| frontiers[side].path_to(lattice, cell));
        let (source, target) = (entries[0][&out[0]], entries[1][&back[0]]);
        let cells: Vec<usize> = out
            .into_iter()
            .chain(back.into_iter().rev().skip(1))
            .collect();
        Connection {
            source,
            target,
            inner: corners(lattice, cells),
        }
    });
    for (side, frontier) in frontiers.into_iter().enumerate() {
        if exhausted == Some(side) {
            frontier.release_component(lattice);
        } else {
            frontier.release(lattice);
        }
    }
    found
}

/// The first cell on which the two searches meet, or which of them has nowhere left to go.
fn meeting<F: Field>(
    lattice: &mut Lattice,
    field: &F,
    frontiers: &mut [Frontier; 2],
) -> Result<usize, usize> {
    loop {
        for side in [0, 1] {
            let (cost, index) = frontiers[side].pop().ok_or(side)?;
            if frontiers[1 - side].reached(index) {
                return Ok(index);
            }
            frontiers[side].expand(lattice, field, cost, index);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::grid::Grid;

    fn rooms(door: bool) -> Grid {
        let mut blocked = vec![0u8; 400];
        for row in 0..20 {
            blocked[20 * row + 10] = u8::from(!door || row != 3);
        }
        Grid::new(blocked, 20, 20, 1.0, Point::new(0.0, 0.0))
    }

    fn terminal(x: f64, y: f64, next: usize) -> Terminal {
        Terminal {
            p: Point::new(x, y),
            next,
        }
    }

    #[test]
    fn two_rooms_are_connected_through_their_door() {
        let field = rooms(true);
        let mut lattice = Lattice::new(&field, 1.0, 0.3);
        let (sources, targets) = ([terminal(2.5, 15.5, 0)], [terminal(17.5, 15.5, 0)]);
        let found = search(&mut lattice, &field, &sources, &targets).expect("the door is open");
        assert!(found.inner.iter().any(|p| (p.y - 3.5).abs() < 0.6));
        let path = [&[sources[0].p], &found.inner[..], &[targets[0].p]].concat();
        assert!(path
            .windows(2)
            .all(|edge| field.segment_clear(edge[0], edge[1], 0.3)));
    }

    #[test]
    fn without_a_door_there_is_no_path_and_the_second_question_costs_no_search() {
        let field = rooms(false);
        let mut lattice = Lattice::new(&field, 1.0, 0.3);
        let ask = |lattice: &mut Lattice| {
            search(
                lattice,
                &field,
                &[terminal(2.5, 2.5, 0)],
                &[terminal(17.5, 2.5, 0)],
            )
            .is_none()
        };
        assert!(ask(&mut lattice));
        assert_eq!(lattice.components.len(), 1);
        assert!(ask(&mut lattice));
        assert_eq!(lattice.components.len(), 1);
    }

    #[test]
    fn of_several_terminals_those_that_meet_first_are_named() {
        let field = rooms(true);
        let mut lattice = Lattice::new(&field, 1.0, 0.3);
        let sources = [terminal(2.5, 18.5, 0), terminal(8.5, 3.5, 1)];
        let found = search(&mut lattice, &field, &sources, &[terminal(12.5, 3.5, 0)]).unwrap();
        assert_eq!((found.source, found.target), (1, 0));
    }
}
