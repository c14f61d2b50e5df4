//! The answer of `Algorithm::Best` without a budget: trees for a quick first path, A* for a short one.

use std::time::Instant;

use crate::geometry::{path_length, Point};
use crate::lattice::feasibility::Feasibility;
use crate::map::field::Field;
use crate::path::tour::{Leg, Tour};
use crate::planner::first_solution::MAX_DOUBTFUL_EXTENSIONS;
use crate::planner::leg_search::LegSearch;
use crate::planner::request::Request;
use crate::tree::rrt::GrowingTree;

/// Tree extensions a leg, before its lattice is searched: enough where a tree has it easy.
const MAX_QUICK_EXTENSIONS: u64 = 100;
/// Cells of the lattice for each of them: on a small lattice A* is as quick as a tree.
const CELLS_AN_EXTENSION: f64 = 1_000.0;
/// Cells of a lattice from which on it is first found out, on coarser ones, whether there is a path at all.
const MIN_PROBED_CELLS: usize = 300_000;
/// Circles up to which tangents do without a lattice's leg to compare with.
const MAX_CIRCLES: usize = 64;
/// Circles near a leg up to which tangents are quickly searched.
const MAX_QUICK_DISCS: usize = 1_000;
/// A leg that is at most so much longer than a straight line is not searched on the lattice.
const GOOD_ENOUGH: f64 = 1.01;

/// The tour through the goals in the order given, and when its first path was known.
pub fn search<F: Field>(legs: &mut LegSearch<F>, request: &Request, start: Point) -> Tour {
    let mut tour = Tour {
        stops: vec![start],
        visits: Vec::new(),
        legs: Vec::new(),
        first: Instant::now(),
    };
    let reachable = |&goal: &usize| legs.field.point_clear(request.goals[goal], request.radius);
    let wanted: Vec<usize> = (0..request.goals.len()).filter(reachable).collect();
    let most = quick_extensions(legs.field, request.radius);
    let mut at = start;
    let mut quick: Vec<Option<Vec<Point>>> = Vec::new();
    for &goal in &wanted {
        quick.push(quick_leg(legs, at, request.goals[goal], most));
        at = request.goals[goal];
    }
    tour.first = Instant::now();
    let complete = quick.iter().all(Option::is_some);
    at = start;
    for (goal, quick) in wanted.into_iter().zip(quick) {
        let to = request.goals[goal];
        // A goal without a path is no stop: the quick leg after it begins elsewhere.
        let quick = quick.filter(|path| path[0] == at);
        if let Some(path) = leg(legs, quick, at, to) {
            tour.stops.push(to);
            tour.visits.push(goal);
            tour.legs.push(Leg { goal, path });
            at = to;
        }
    }
    if !complete {
        tour.first = Instant::now();
    }
    tour
}

/// Extensions of a quick tree that are worth while on this map.
fn quick_extensions<F: Field>(field: &F, radius: f64) -> u64 {
    if field.circular_obstacles().is_some() {
        return MAX_QUICK_EXTENSIONS;
    }
    let (low, high) = field.bounds();
    let spacings = field.lattice_spacings(radius);
    let spacing = spacings[spacings.len() - 1];
    let cells = (high.x - low.x) * (high.y - low.y) / (spacing * spacing);
    MAX_QUICK_EXTENSIONS.min((cells / CELLS_AN_EXTENSION) as u64)
}

/// A straight line, or what a small tree finds.
fn quick_leg<F: Field>(
    legs: &mut LegSearch<F>,
    from: Point,
    to: Point,
    most: u64,
) -> Option<Vec<Point>> {
    if legs.field.segment_clear(from, to, legs.growth.radius) {
        return Some(vec![from, to]);
    }
    let mut tree = GrowingTree::new(legs.field, from, &[to], legs.growth);
    legs.grow(&mut tree, &[to], &[true], most);
    tree.reached[0].map(|node| tree.tree.path_to(node))
}

/// The shorter of the `quick` leg and A*'s; none when there is no path.
fn leg<F: Field>(
    legs: &mut LegSearch<F>,
    quick: Option<Vec<Point>>,
    from: Point,
    to: Point,
) -> Option<Vec<Point>> {
    let quick = quick.map(|path| legs.quickly_simplified(path));
    if let Some(path) = quick
        .as_ref()
        .filter(|path| legs.excess(path) <= GOOD_ENOUGH)
    {
        return Some(path.clone());
    }
    let circles = legs.field.circular_obstacles().map(<[_]>::len);
    if circles.is_some_and(|count| count <= MAX_CIRCLES) {
        let found = tangents(legs, &quick, from, to);
        return found.or(quick).or_else(|| last_resort(legs, from, to));
    }
    let mut lattice = legs.take_lattice();
    let mut quick = quick;
    if quick.is_none() && lattice.size() > MIN_PROBED_CELLS {
        // A goal without a path would cost a look at the whole lattice.
        quick = Some(last_resort(legs, from, to)?);
    }
    let found = legs.a_star(&mut lattice, from, to);
    legs.lattices.give(lattice);
    let found = match (quick, found) {
        (Some(quick), Some(found)) if legs.cost(&quick) < legs.cost(&found) => Some(quick),
        (quick, found) => found.or(quick),
    };
    match found {
        None => last_resort(legs, from, to),
        // Passages that the lattice does not show may be shorter.
        known => tangents(legs, &known, from, to).or(known),
    }
}

/// A leg among circles that is better than the one that is `known`, if there is one and it is quickly found.
fn tangents<F: Field>(
    legs: &mut LegSearch<F>,
    known: &Option<Vec<Point>>,
    from: Point,
    to: Point,
) -> Option<Vec<Point>> {
    let bound = known.as_deref().map_or(f64::INFINITY, path_length);
    let cost = known
        .as_deref()
        .map_or(f64::INFINITY, |path| legs.cost(path));
    let found = legs.tangents(from, to, (bound, MAX_QUICK_DISCS));
    found.filter(|path| legs.cost(path) < cost)
}

/// For passages that the lattice does not show: finer lattices, then tangents among circles, or else a large tree. None when there is no path.
fn last_resort<F: Field>(legs: &mut LegSearch<F>, from: Point, to: Point) -> Option<Vec<Point>> {
    let most = match legs.first_lattice_path(from, to) {
        Feasibility::Path(path) => return Some(legs.simplified(path)),
        Feasibility::Infeasible => return None,
        Feasibility::Unknown => MAX_DOUBTFUL_EXTENSIONS,
    };
    if legs.field.circular_obstacles().is_some() {
        return legs.tangents(from, to, (f64::INFINITY, usize::MAX));
    }
    let mut tree = GrowingTree::new(legs.field, from, &[to], legs.growth);
    legs.grow(&mut tree, &[to], &[true], most);
    let path = tree.tree.path_to(tree.reached[0]?);
    Some(legs.simplified(path))
}

/// Every leg of a tour by A*, and by tangents among circles, where that is shorter.
pub fn shorten<F: Field>(legs: &mut LegSearch<F>, tour: &mut Tour) {
    let mut lattice = legs.take_lattice();
    for leg in &mut tour.legs {
        if legs.excess(&leg.path) <= GOOD_ENOUGH {
            continue;
        }
        let (from, to) = (leg.path[0], leg.path[leg.path.len() - 1]);
        let found = legs.a_star(&mut lattice, from, to);
        if let Some(path) = found.filter(|path| legs.cost(path) < legs.cost(&leg.path)) {
            leg.path = path;
        }
        let known = Some(std::mem::take(&mut leg.path));
        leg.path = (tangents(legs, &known, from, to).or(known)).unwrap_or_default();
    }
    legs.lattices.give(lattice);
}
