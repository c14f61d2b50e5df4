//! Connects goals that the tree has not reached to it by searches over lattices, coarse ones first; or proves that they
//! have no path.

use crate::geometry::{distance_squared, Point};
use crate::lattice::bidirectional::{self, Terminal};
use crate::lattice::feasibility;
use crate::lattice::graph::Lattice;
use crate::map::field::Field;
use crate::tree::rrt::GrowingTree;

/// How many of the tree's nodes nearest to a goal its search may end at, beside the root.
const MAX_NODES: usize = 16;

/// Connects each goal that is `wanted` and not reached to the tree. A goal without a path is no longer wanted; one that is
/// still wanted may have a path, but only through passages finer than the finest lattice. Returns the coarsest lattice,
/// when there was anything to do.
pub fn connect_goals<F: Field>(
    field: &F,
    growing: &mut GrowingTree,
    goals: &[Point],
    wanted: &mut [bool],
    radius: f64,
) -> Option<Lattice> {
    let open = |growing: &GrowingTree, wanted: &[bool]| -> Vec<usize> {
        (0..goals.len())
            .filter(|&goal| wanted[goal] && growing.reached[goal].is_none())
            .collect()
    };
    if open(growing, wanted).is_empty() {
        return None;
    }
    let start = growing.tree.points[0];
    let spacings = field.lattice_spacings(radius);
    let mut coarsest = None;
    for &spacing in &spacings {
        let mut lattice = Lattice::new(field, spacing, radius);
        for goal in open(growing, wanted) {
            connect_goal(field, &mut lattice, growing, goal, goals[goal]);
        }
        coarsest.get_or_insert(lattice);
    }
    let fine = Lattice::new(field, spacings[spacings.len() - 1], radius);
    for goal in open(growing, wanted) {
        wanted[goal] = feasibility::may_reach(&fine, field, start, goals[goal]);
    }
    let left = open(growing, wanted);
    if !left.is_empty() {
        let mut lattice = Lattice::tightest(field, radius);
        for goal in left {
            connect_goal(field, &mut lattice, growing, goal, goals[goal]);
        }
    }
    coarsest
}

/// Connects one goal to the tree if the lattice has a path.
fn connect_goal<F: Field>(
    field: &F,
    lattice: &mut Lattice,
    growing: &mut GrowingTree,
    goal: usize,
    at: Point,
) {
    let tree = &mut growing.tree;
    let mut nodes: Vec<usize> = (1..tree.points.len()).collect();
    let key = |&node: &usize| distance_squared(tree.points[node], at);
    if nodes.len() > MAX_NODES {
        nodes.select_nth_unstable_by(MAX_NODES - 1, |a, b| {
            key(a).total_cmp(&key(b)).then(a.cmp(b))
        });
        nodes.truncate(MAX_NODES);
    }
    nodes.sort_unstable_by(|a, b| key(a).total_cmp(&key(b)).then(a.cmp(b)));
    nodes.push(0);
    let terminal = |p: Point, next: usize| Terminal { p, next };
    let sources: Vec<Terminal> = (nodes.iter())
        .map(|&node| terminal(tree.points[node], node))
        .collect();
    if let Some(found) = bidirectional::search(lattice, field, &sources, &[terminal(at, 0)]) {
        let first = nodes[found.source];
        let node = (found.inner.into_iter()).fold(first, |node, p| tree.add(p, node));
        growing.reached[goal] = Some(tree.add(at, node));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::grid::Grid;
    use crate::tree::rrt::GrowthSettings;

    #[test]
    fn a_goal_behind_a_door_is_connected_and_a_walled_in_one_is_given_up() {
        let mut blocked = vec![0u8; 10_000];
        blocked[5_000..5_090].fill(1); // a wall with a door of 1 m on the right
        for row in 80..100 {
            blocked[100 * row + 20] = 1; // a closed corner at the top left
        }
        blocked[8_000..8_021].fill(1);
        let field = Grid::new(blocked, 100, 100, 0.1, Point::new(0.0, 0.0));
        let growth = GrowthSettings {
            radius: 0.2,
            step: 0.5,
            bias: 0.0,
        };
        let goals = [Point::new(5.0, 7.0), Point::new(1.0, 9.0)];
        let mut tree = GrowingTree::new(&field, Point::new(1.0, 1.0), &goals, growth);
        let mut wanted = vec![true; 2];
        let lattice = connect_goals(&field, &mut tree, &goals, &mut wanted, growth.radius);
        assert!(lattice.is_some());
        assert_eq!(wanted, [true, false]);
        let node = tree.reached[0].expect("the door is open");
        let path = tree.tree.path_to(node);
        assert!(path
            .windows(2)
            .all(|edge| field.segment_clear(edge[0], edge[1], 0.2)));
        assert!(path.iter().any(|p| p.x > 9.0));
    }
}
