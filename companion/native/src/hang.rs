//! Goals that the tree has not reached are hung on it by searches over lattices, coarse ones first; or it is proved that
//! they have no way.

use crate::field::Field;
use crate::geometry::{distance_squared, Point};
use crate::lattice::Lattice;
use crate::rrt::Grown;
use crate::search::{self, Stop};

/// How many of the tree's nodes nearest to a goal its search may end at, beside the root.
const NODES: usize = 16;

/// Hangs each goal that is `wanted` and not reached on the tree. A goal without a way is no longer wanted; one that is
/// still wanted may have a way, but only through passages finer than the finest lattice. Also the coarsest lattice, when
/// there was anything to do.
pub fn hang<F: Field>(
    field: &F,
    grown: &mut Grown,
    goals: &[Point],
    wanted: &mut [bool],
    radius: f64,
) -> Option<Lattice> {
    let open = |grown: &Grown, wanted: &[bool]| -> Vec<usize> {
        (0..goals.len())
            .filter(|&goal| wanted[goal] && grown.reached[goal].is_none())
            .collect()
    };
    if open(grown, wanted).is_empty() {
        return None;
    }
    let start = grown.tree.points[0];
    let spacings = field.lattice_spacings(radius);
    let mut coarsest = None;
    for &spacing in &spacings {
        let mut lattice = Lattice::new(field, spacing, radius);
        for goal in open(grown, wanted) {
            hang_one(field, &mut lattice, grown, goal, goals[goal]);
        }
        coarsest.get_or_insert(lattice);
    }
    let fine = Lattice::new(field, spacings[spacings.len() - 1], radius);
    for goal in open(grown, wanted) {
        wanted[goal] = fine.possible(field, start, goals[goal]);
    }
    let left = open(grown, wanted);
    if !left.is_empty() {
        let mut lattice = Lattice::tightest(field, radius);
        for goal in left {
            hang_one(field, &mut lattice, grown, goal, goals[goal]);
        }
    }
    coarsest
}

/// Hangs one goal on the tree if the lattice has a way.
fn hang_one<F: Field>(field: &F, lattice: &mut Lattice, grown: &mut Grown, goal: usize, at: Point) {
    let tree = &mut grown.tree;
    let mut nodes: Vec<usize> = (1..tree.points.len()).collect();
    let key = |&node: &usize| distance_squared(tree.points[node], at);
    if nodes.len() > NODES {
        nodes.select_nth_unstable_by(NODES - 1, |a, b| key(a).total_cmp(&key(b)).then(a.cmp(b)));
        nodes.truncate(NODES);
    }
    nodes.sort_unstable_by(|a, b| key(a).total_cmp(&key(b)).then(a.cmp(b)));
    nodes.push(0);
    let stop = |p: Point, next: usize| Stop { p, next };
    let stops: Vec<Stop> = nodes.iter().map(|&n| stop(tree.points[n], n)).collect();
    if let Some((from, _, way)) = search::joint(lattice, field, &stops, &[stop(at, 0)]) {
        let node = way
            .into_iter()
            .fold(nodes[from], |node, p| tree.add(p, node));
        grown.reached[goal] = Some(tree.add(at, node));
    }
}
