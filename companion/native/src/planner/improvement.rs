//! Makes a tour shorter for as long as the budget lasts.

use std::collections::BTreeMap;
use std::time::Instant;

use crate::budget::Pace;
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

/// Legs over finer and finer lattices, then RRT-Connect and random shortcuts, leg by leg, until the budget is spent or
/// every leg is a straight line.
pub fn improve<F: Field>(legs: &mut LegSearch<F>, tour: &mut Tour, any_order: bool) {
    over_lattices(legs, tour, any_order);
    let mut round = 0usize;
    let mut best: Vec<f64> = tour.legs.iter().map(|leg| legs.cost(&leg.path)).collect();
    while !legs.budget.exhausted() && !legs.budget.late() && tour.is_winding() {
        for (leg, best) in tour.legs.iter_mut().zip(&mut best) {
            if leg.path.len() <= 2 || !legs.budget.spend() {
                continue;
            }
            let (candidate, nodes) = candidate(legs, leg, *best, round);
            tour.nodes += nodes;
            if let Some(mut path) = candidate {
                simplify::refine(legs.field, &mut path, legs.simplification);
                let cost = legs.cost(&path);
                if cost < *best {
                    *best = cost;
                    leg.path = path;
                }
            }
        }
        round += 1;
    }
}

/// Legs, or the whole tour, over finer and finer lattices as far as the budget affords them.
fn over_lattices<F: Field>(legs: &mut LegSearch<F>, tour: &mut Tour, any_order: bool) {
    let radius = legs.simplification.radius;
    let mut pace = Pace::default();
    for spacing in legs.field.lattice_spacings(radius) {
        let (low, high) = legs.field.bounds();
        let cells = (high.x - low.x) * (high.y - low.y) / (spacing * spacing);
        if !tour.is_winding() || !legs.budget.affords(pace.expected(cells), cells) {
            break;
        }
        let began = Instant::now();
        let mut lattice = Lattice::new(legs.field, spacing, radius);
        if any_order && tour.legs.len() > 1 {
            reorder(legs, tour, &mut lattice);
        } else {
            replace_legs(legs, tour, &mut lattice);
        }
        pace.saw(cells, began.elapsed().as_secs_f64());
    }
}

/// Something that may become a better leg: the leg itself, shortcuts, or a fresh search. Also how many nodes were made.
fn candidate<F: Field>(
    legs: &mut LegSearch<F>,
    leg: &Leg,
    best: f64,
    round: usize,
) -> (Option<Vec<Point>>, usize) {
    let (from, to) = (leg.path[0], leg.path[leg.path.len() - 1]);
    if round == 0 {
        return (Some(leg.path.clone()), 0);
    }
    if round % SHORTCUT_PERIOD == SHORTCUT_PERIOD - 1 {
        let mut path = leg.path.clone();
        simplify::random_shortcuts(
            legs.field,
            &mut path,
            legs.simplification,
            SHORTCUT_ATTEMPTS,
            legs.random,
            legs.budget,
        );
        return (Some(path), 0);
    }
    let (path, nodes) = legs.rrt_connect(from, to);
    let promising = |path: &Vec<Point>| legs.cost(path) < MAX_CANDIDATE_GROWTH * best;
    (path.filter(promising), nodes)
}

/// Each leg by A* over the lattice where that is shorter.
fn replace_legs<F: Field>(legs: &LegSearch<F>, tour: &mut Tour, lattice: &mut Lattice) {
    for leg in &mut tour.legs {
        if leg.path.len() <= 2 || legs.budget.late() {
            continue;
        }
        let (from, to) = (leg.path[0], leg.path[leg.path.len() - 1]);
        if let Some(path) = legs.a_star(lattice, from, to) {
            if legs.cost(&path) < legs.cost(&leg.path) {
                leg.path = path;
            }
        }
    }
}

/// The best order by A* between stops, taken when that tour is shorter.
fn reorder<F: Field>(legs: &LegSearch<F>, tour: &mut Tour, lattice: &mut Lattice) {
    let stops = tour.stops.clone();
    let mut paths: BTreeMap<(usize, usize), Vec<Point>> = BTreeMap::new();
    // What the tour has already may be shorter than what the lattice can say.
    let mut from = 0usize;
    for leg in &tour.legs {
        let to = 1 + tour.visits.iter().position(|&v| v == leg.goal).unwrap_or(0);
        let path = leg.path.clone();
        let path = if from < to { path } else { reversed(path) };
        paths.insert((from.min(to), from.max(to)), path);
        from = to;
    }
    let order = visit_order::lazily(straight_distances(&stops), |from, to| {
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
        let Some(path) = paths.get(&(from.min(to), from.max(to))).cloned() else {
            return;
        };
        reordered.push(Leg {
            goal: tour.visits[to - 1],
            path: if from < to { path } else { reversed(path) },
        });
        from = to;
    }
    let total = |tour: &[Leg]| -> f64 { tour.iter().map(|leg| legs.cost(&leg.path)).sum() };
    if total(&reordered) < total(&tour.legs) {
        tour.legs = reordered;
    }
}
