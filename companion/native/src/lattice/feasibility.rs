//! Whether a goal can be reached at all, and by which path.

use crate::geometry::Point;
use crate::lattice::bidirectional::{self, Terminal};
use crate::lattice::graph::Lattice;
use crate::map::field::Field;

/// A little more than half the diagonal of a cell, in spacings.
const HALF_DIAGONAL: f64 = 0.7072;

/// What the lattices know of the path to a goal.
#[derive(Debug, PartialEq)]
pub enum Feasibility {
    /// A path with exact edges, both ends included.
    Path(Vec<Point>),
    /// No path was found; one may exist through passages finer than the finest lattice.
    Unknown,
    /// Proof that there is no path.
    Infeasible,
}

/// A path from `start` to `goal` over the lattices, coarse ones first. Only the finest one's flood proves anything; what
/// that leaves open is searched once more on the tightest lattice.
pub fn first_path<F: Field>(field: &F, start: Point, goal: Point, radius: f64) -> Feasibility {
    let spacings = field.lattice_spacings(radius);
    let ends = [start, goal].map(|p| Terminal { p, next: 0 });
    let found = |mut lattice: Lattice| {
        let (sources, targets) = ends.split_at(1);
        let connection = bidirectional::search(&mut lattice, field, sources, targets)?;
        Some([vec![start], connection.inner, vec![goal]].concat())
    };
    let coarse_to_fine = (spacings.iter()).map(|&spacing| Lattice::new(field, spacing, radius));
    if let Some(path) = coarse_to_fine.into_iter().find_map(found) {
        return Feasibility::Path(path);
    }
    let finest = Lattice::new(field, spacings[spacings.len() - 1], radius);
    if !may_reach(&finest, field, start, goal) {
        return Feasibility::Infeasible;
    }
    match found(Lattice::tightest(field, radius)) {
        Some(path) => Feasibility::Path(path),
        None => Feasibility::Unknown,
    }
}

/// False when `goal` certainly cannot be reached: of two floods, from there and from `start`, over every cell that could
/// hold any position of the robot at all, one ends without meeting the other.
pub fn may_reach<F: Field>(lattice: &Lattice, field: &F, start: Point, goal: Point) -> bool {
    let ends = [start, goal].map(|p| {
        let (column, row) = lattice.cell(p);
        lattice.index(column, row)
    });
    let [Some(start), Some(goal)] = ends else {
        return false;
    };
    if start == goal {
        return true;
    }
    // Clearance is 1-Lipschitz: no point of a cell has more than its centre's plus the half diagonal.
    let least = lattice.radius - HALF_DIAGONAL * lattice.spacing;
    let mut flooded = vec![0u8; lattice.size()];
    let mut pending = [vec![start], vec![goal]];
    (flooded[start], flooded[goal]) = (1, 2);
    loop {
        for side in [0, 1] {
            let Some(at) = pending[side].pop() else {
                return false;
            };
            let (own, other) = (side as u8 + 1, 2 - side as u8);
            for next in lattice.neighbours(at) {
                if flooded[next] == other {
                    return true;
                }
                if flooded[next] == 0 && field.may_hold(lattice.point(next), least) {
                    flooded[next] = own;
                    pending[side].push(next);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::grid::Grid;

    /// 2 × 2 m in cells of 5 cm, a wall across with a gap of so many cells.
    fn gap(cells: usize) -> Grid {
        let mut blocked = vec![0u8; 1600];
        blocked[800..840].fill(1);
        blocked[820..820 + cells].fill(0);
        Grid::new(blocked, 40, 40, 0.05, Point::new(0.0, 0.0))
    }

    fn across(field: &Grid) -> Feasibility {
        first_path(field, Point::new(0.5, 0.5), Point::new(0.5, 1.6), 0.1)
    }

    #[test]
    fn a_closed_wall_is_proof_that_there_is_no_path() {
        assert_eq!(across(&gap(0)), Feasibility::Infeasible);
        assert_eq!(across(&gap(2)), Feasibility::Infeasible);
    }

    #[test]
    fn a_gap_as_wide_as_the_robot_is_found() {
        for cells in [4, 5] {
            let field = gap(cells);
            let Feasibility::Path(path) = across(&field) else {
                panic!("a gap of {cells} cells of 5 cm is open to a robot of 20 cm");
            };
            assert!(path
                .windows(2)
                .all(|edge| field.segment_clear(edge[0], edge[1], 0.1)));
        }
    }
}
