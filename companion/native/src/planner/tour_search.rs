//! From the first paths to a tour: the order of visit, and legs that are already short.

use std::collections::BTreeMap;
use std::time::Instant;

use crate::geometry::{path_length, Point};
use crate::lattice::graph::Lattice;
use crate::map::field::Field;
use crate::path::tour::{reversed, straight_distances, Leg, Tour};
use crate::path::visit_order;
use crate::planner::first_solution::FirstSolution;
use crate::planner::leg_search::LegSearch;
use crate::replan::state::ReplanState;
use crate::replan::stop_name::{name_of, Name};
use crate::tree::rrt::GrowingTree;

/// The tour through all goals of `found`, in the order given or in the best one. Old legs that `state` holds are repaired
/// where the map has changed.
pub fn search<F: Field>(
    legs: &mut LegSearch<F>,
    found: &mut FirstSolution,
    goals: &[Point],
    any_order: bool,
    state: &mut ReplanState,
) -> Tour {
    let mut tour = Tour {
        stops: vec![found.start],
        visits: found.visits.clone(),
        legs: Vec::new(),
        first: Instant::now(),
    };
    tour.stops.extend(found.visits.iter().map(|&v| goals[v]));
    let lattice = found.lattice.take();
    let found = &*found;
    match &found.tree {
        None => {
            for (&goal, path) in found.visits.iter().zip(&found.paths) {
                let path = legs.simplified(path.clone());
                tour.legs.push(Leg { goal, path });
            }
        }
        Some(tree) => through_tree(legs, found, tree, lattice, any_order, state, &mut tour),
    }
    tour
}

/// The legs of a tour over one tree, each repaired, searched on the lattice, or taken from the tree and shortened.
fn through_tree<F: Field>(
    legs: &mut LegSearch<F>,
    found: &FirstSolution,
    tree: &GrowingTree,
    mut lattice: Option<Lattice>,
    any_order: bool,
    state: &mut ReplanState,
    tour: &mut Tour,
) {
    let stops = tour.stops.clone();
    let name = |stop: usize| -> Name { (stop > 0).then(|| name_of(stops[stop])).flatten() };
    let mut leg = |from: usize, to: usize, old: Option<Vec<Point>>| {
        let ends = (stops[from], stops[to]);
        let repaired = old
            .and_then(|old| (state.leg_repair).repair(legs.field, &old, ends, legs.simplification));
        repaired.unwrap_or_else(|| {
            let tree_path = || found.tree_path(tree, from, to);
            legs.fresh(&mut lattice, tree_path, ends)
        })
    };
    let kept = &mut state.legs;
    let mut paths: BTreeMap<(usize, usize), Vec<Point>> = BTreeMap::new();
    let sequence = if any_order {
        visit_order::lazily(straight_distances(&stops), |from, to| {
            let old = kept.remove(&(name(from), name(to)));
            let old = old.or_else(|| kept.remove(&(name(to), name(from))).map(reversed));
            let path = leg(from, to, old);
            let length = path_length(&path);
            paths.insert((from, to), path);
            length
        })
    } else {
        (1..stops.len()).collect()
    };
    let mut from = 0usize;
    for to in sequence {
        let path = paths
            .remove(&(from, to))
            .or_else(|| paths.remove(&(to, from)).map(reversed))
            .unwrap_or_else(|| leg(from, to, kept.remove(&(name(from), name(to)))));
        tour.legs.push(Leg {
            goal: found.visits[to - 1],
            path,
        });
        from = to;
    }
    for ((from, to), path) in paths {
        kept.insert((name(from), name(to)), path);
    }
    if let Some(lattice) = lattice {
        state.leg_repair.keep_lattice(legs.field, lattice);
    }
}
