//! What the paper's algorithms do with a budget: the same again with other random numbers, and RRT* goes on rewiring.
//!
//! As in `improvement`, the budget only decides how many of the same steps are taken, so that more is never worse.

use std::time::Instant;

use crate::geometry::Point;
use crate::map::field::Field;
use crate::path::tour::{Leg, Tour};
use crate::planner::first_solution::{self, Means};
use crate::planner::leg_search::LegSearch;
use crate::planner::request::Request;
use crate::planner::tour_search;
use crate::replan::state::ReplanState;
use crate::tree::rrt_star::RrtStar;

/// Extensions of one RRT* before the next leg has its turn.
const EXTENSIONS_A_TURN: usize = 64;

/// Plans anew until the budget is spent and keeps the shortest tour. Where a lattice had to help, trees would hardly
/// find anything else, and this ends.
pub fn restart<F: Field>(
    legs: &mut LegSearch<F>,
    request: &Request,
    start: Point,
    mut by_lattice: bool,
    tour: &mut Tour,
) {
    let over = |legs: &LegSearch<F>| legs.budget.exhausted() || legs.budget.late();
    let total = |legs: &LegSearch<F>, tour: &Tour| -> f64 {
        tour.legs.iter().map(|leg| legs.cost(&leg.path)).sum()
    };
    while !over(legs) && tour.is_winding() && !by_lattice {
        legs.budget.spend();
        let state = &mut ReplanState::new(request.seed);
        let mut found = first_solution::search(legs, request, start, state, Means::Trees);
        let other = tour_search::search(legs, &mut found, &request.goals, request.any_order, state);
        by_lattice |= found.by_lattice;
        let complete = other.legs.len() == tour.legs.len() && !over(legs);
        if complete && total(legs, &other) < total(legs, tour) {
            tour.legs = other.legs;
        }
    }
}

/// Rewires the trees of RRT*, leg by leg in turns, until the budget is spent.
pub fn rewire<F: Field>(legs: &mut LegSearch<F>, stars: &mut [Option<RrtStar>], tour: &mut Tour) {
    let active = |leg: &Leg| leg.path.len() > 2;
    while !legs.budget.exhausted() && !legs.budget.late() {
        let mut busy = false;
        for (star, leg) in stars.iter_mut().zip(&mut tour.legs) {
            if let Some(star) = star.as_mut().filter(|_| active(leg)) {
                busy = true;
                rewire_leg(legs, star, leg);
            }
        }
        if !busy {
            return;
        }
    }
}

/// One turn of one leg; dropped when the budget ends in it.
fn rewire_leg<F: Field>(legs: &mut LegSearch<F>, star: &mut RrtStar, leg: &mut Leg) {
    let (began, cost, nodes) = (Instant::now(), star.cost(), star.nodes());
    let mut spent = 0;
    while spent < EXTENSIONS_A_TURN && legs.budget.spend() {
        star.extend(legs.field, legs.growth, legs.random);
        spent += 1;
    }
    legs.stages.record("rewiring", began, spent as u64);
    legs.stages.nodes += star.nodes() - nodes;
    if spent == EXTENSIONS_A_TURN && star.cost() < cost {
        if let Some(path) = star.path() {
            let path = legs.simplified(path);
            if !legs.budget.late() && legs.cost(&path) < legs.cost(&leg.path) {
                leg.path = path;
            }
        }
    }
}
