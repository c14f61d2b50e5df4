//! Makes a tour shorter for as long as the budget lasts.
//!
//! Whatever the budget, the steps are the same and come in the same order; it only decides how many of them are taken. A
//! step either makes the tour shorter or leaves it as it is, and one that the budget ends is dropped as a whole. So more
//! budget is never worse: the shorter budget's answer is on the way to the longer one's.

use std::collections::BTreeMap;
use std::time::Instant;

use crate::geometry::{path_length, Point};
use crate::lattice::graph::Lattice;
use crate::map::field::Field;
use crate::path::simplify;
use crate::path::tour::{reversed, straight_distances, Leg, Tour};
use crate::path::visit_order;
use crate::planner::leg_search::LegSearch;

/// A new leg is refined when it is at most so much longer than the best one.
const MAX_CANDIDATE_GROWTH: f64 = 1.1;
/// Every so many rounds a leg is shortened by random shortcuts instead of being searched anew.
const SHORTCUT_PERIOD: usize = 4;
/// Random shortcuts that are then tried.
const SHORTCUT_ATTEMPTS: usize = 16;

/// Refines the legs, leads them along tangents among circles, orders the goals anew where that is allowed, then tries RRT-Connect and random shortcuts, leg by
/// leg, until the budget is spent or every leg is a straight line.
pub fn improve<F: Field>(legs: &mut LegSearch<F>, tour: &mut Tour, any_order: bool) {
    let over = |legs: &LegSearch<F>| legs.budget.exhausted() || legs.budget.late();
    refine_all(legs, tour);
    by_tangents(legs, tour);
    if any_order && tour.legs.len() > 1 && !over(legs) {
        let mut lattice = legs.take_lattice();
        if let Some(reordered) = reordered(legs, tour, &mut lattice) {
            tour.legs = reordered;
            refine_all(legs, tour);
            by_tangents(legs, tour);
        }
        legs.lattices.give(lattice);
    }
    let mut round = 0usize;
    while !over(legs) && tour.is_winding() {
        for leg in &mut tour.legs {
            if leg.path.len() <= 2 || !legs.budget.spend() {
                continue;
            }
            if let Some(path) = candidate(legs, leg, round) {
                replace_by_refined(legs, leg, path);
            }
        }
        round += 1;
    }
}

/// Refines every leg once.
fn refine_all<F: Field>(legs: &mut LegSearch<F>, tour: &mut Tour) {
    for leg in &mut tour.legs {
        if leg.path.len() > 2 && legs.budget.spend() {
            let path = leg.path.clone();
            replace_by_refined(legs, leg, path);
        }
    }
}

/// Every leg by tangents where that is better; among circles nothing is shorter.
fn by_tangents<F: Field>(legs: &mut LegSearch<F>, tour: &mut Tour) {
    for leg in &mut tour.legs {
        if leg.path.len() <= 2 || !legs.budget.spend() {
            continue;
        }
        let (from, to) = (leg.path[0], leg.path[leg.path.len() - 1]);
        let bound = path_length(&leg.path);
        let found = legs.tangents(from, to, (bound, usize::MAX));
        let better = |path: &Vec<Point>| legs.cost(path) < legs.cost(&leg.path);
        if let Some(path) = found.filter(better).filter(|_| !legs.budget.late()) {
            leg.path = path;
        }
    }
}

/// Puts `path`, refined, in the place of the leg's if it is better and the budget has lasted.
fn replace_by_refined<F: Field>(legs: &mut LegSearch<F>, leg: &mut Leg, mut path: Vec<Point>) {
    let began = Instant::now();
    simplify::refine(legs.field, &mut path, legs.simplification);
    legs.stages.record("refine", began, 1);
    if !legs.budget.late() && legs.cost(&path) < legs.cost(&leg.path) {
        leg.path = path;
    }
}

/// Something that may become a better leg, by shortcuts or a fresh search; none when it does not look like it, or the
/// budget has ended before it was made.
fn candidate<F: Field>(legs: &mut LegSearch<F>, leg: &Leg, round: usize) -> Option<Vec<Point>> {
    let (from, to) = (leg.path[0], leg.path[leg.path.len() - 1]);
    let path = if round % SHORTCUT_PERIOD == SHORTCUT_PERIOD - 1 {
        let mut path = leg.path.clone();
        let (began, used) = (Instant::now(), legs.budget.used);
        simplify::random_shortcuts(
            legs.field,
            &mut path,
            legs.simplification,
            SHORTCUT_ATTEMPTS,
            legs.random,
            legs.budget,
        );
        (legs.stages).record("shortcuts", began, legs.budget.used - used);
        path
    } else {
        legs.rrt_connect(from, to)?
    };
    let over = legs.budget.exhausted() || legs.budget.late();
    let promising = legs.cost(&path) < MAX_CANDIDATE_GROWTH * legs.cost(&leg.path);
    (promising && !over).then_some(path)
}

/// The legs of the best order by A* between stops, when that tour is shorter and the budget has lasted.
fn reordered<F: Field>(
    legs: &mut LegSearch<F>,
    tour: &Tour,
    lattice: &mut Lattice,
) -> Option<Vec<Leg>> {
    let stops = &tour.stops;
    let mut paths: BTreeMap<(usize, usize), Vec<Point>> = BTreeMap::new();
    // What the tour has already may be shorter than what the lattice can say.
    let mut from = 0usize;
    for leg in &tour.legs {
        let to = 1 + tour.visits.iter().position(|&v| v == leg.goal)?;
        let path = leg.path.clone();
        let path = if from < to { path } else { reversed(path) };
        paths.insert((from.min(to), from.max(to)), path);
        from = to;
    }
    let order = visit_order::lazily(straight_distances(stops), |from, to| {
        let key = (from.min(to), from.max(to));
        let known = paths.get(&key).map(|path| path_length(path));
        if legs.budget.late() {
            return known.unwrap_or(f64::INFINITY);
        }
        let path = legs.a_star(lattice, stops[key.0], stops[key.1]);
        let length = path.as_deref().map_or(f64::INFINITY, path_length);
        if let Some(path) = path.filter(|_| known.is_none_or(|known| length < known)) {
            paths.insert(key, path);
        }
        length.min(known.unwrap_or(f64::INFINITY))
    });
    let mut reordered = Vec::new();
    let mut from = 0usize;
    for to in order {
        let path = paths.get(&(from.min(to), from.max(to))).cloned()?;
        reordered.push(Leg {
            goal: tour.visits[to - 1],
            path: if from < to { path } else { reversed(path) },
        });
        from = to;
    }
    let total = |tour: &[Leg]| -> f64 { tour.iter().map(|leg| legs.cost(&leg.path)).sum() };
    let better = total(&reordered) < total(&tour.legs);
    (better && !legs.budget.late()).then_some(reordered)
}
