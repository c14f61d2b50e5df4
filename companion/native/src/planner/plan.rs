//! One plan: from a request to a path through all goals, then better for as long as the budget lasts.

use std::time::Instant;

use crate::budget::Budget;
use crate::geometry::Point;
use crate::lattice::cache::LatticeCache;
use crate::map::field::Field;
use crate::path::simplify::{self, Simplification};
use crate::path::tour::Tour;
use crate::planner::best;
use crate::planner::first_solution::{self, FirstSolution, Means, MAX_EXTENSIONS};
use crate::planner::improvement;
use crate::planner::leg_search::LegSearch;
use crate::planner::request::{Algorithm, Outcome, Request};
use crate::planner::restarts;
use crate::planner::stages::Stages;
use crate::planner::start_recovery;
use crate::planner::tour_search;
use crate::replan::state::{Repair, ReplanState};
use crate::replan::stop_name::name_of;
use crate::replan::tour_repair;

/// The answer to a request: the same for the same arguments, unless there is a budget in milliseconds.
pub fn plan<F: Field>(field: &F, request: &Request, lattices: &mut LatticeCache) -> Outcome {
    let state = &mut ReplanState::new(request.seed);
    answer(field, request, lattices, state, improve_as_asked)
}

/// The same for `MultiGoal`, starting from what `state` holds of the plan before; improved as for `Best`.
pub fn replan<F: Field>(
    field: &F,
    request: &Request,
    lattices: &mut LatticeCache,
    state: &mut ReplanState,
) -> Outcome {
    answer(
        field,
        request,
        lattices,
        state,
        |legs, request, _, _, tour| {
            best::shorten(legs, tour);
            improvement::improve(legs, tour, request.any_order);
        },
    )
}

/// What each algorithm does with a budget.
fn improve_as_asked<F: Field>(
    legs: &mut LegSearch<F>,
    request: &Request,
    entry: Point,
    found: &mut FirstSolution,
    tour: &mut Tour,
) {
    match request.algorithm {
        Algorithm::Best => improvement::improve(legs, tour, request.any_order),
        Algorithm::RrtStar => restarts::rewire(legs, &mut found.stars, tour),
        _ => restarts::restart(legs, request, entry, found.by_lattice, tour),
    }
}

/// The answer that comes without a budget, then improved within one.
fn answer<F: Field>(
    field: &F,
    request: &Request,
    lattices: &mut LatticeCache,
    state: &mut ReplanState,
    improve: impl FnOnce(&mut LegSearch<F>, &Request, Point, &mut FirstSolution, &mut Tour),
) -> Outcome {
    let started = Instant::now();
    let Some(entry) = clear_start(field, request) else {
        return start_blocked(request, started);
    };
    // No budget cuts the answer short that comes without one: it is about how long to go on improving.
    let goals = request.goals.len().max(1) as u64;
    let mut budget = Budget::new(MAX_EXTENSIONS * goals);
    let mut random = state.random.clone();
    let mut stages = Stages::default();
    let mut legs = LegSearch {
        field,
        growth: request.growth(field),
        simplification: Simplification {
            radius: request.radius,
            corner_cost: request.corner_cost,
            least_move: simplify::LEAST_MOVE,
            deadline: None,
        },
        random: &mut random,
        budget: &mut budget,
        lattices,
        stages: &mut stages,
    };
    state.repair = Repair::default();
    state.leg_repair.begin_map(field, request.radius);
    let (mut tour, mut found) = first_tour(&mut legs, request, entry, state);
    let first = (!tour.legs.is_empty()).then(|| tour.first.duration_since(started));
    let limited = request.iterations.is_some() || request.budget_ms.is_some();
    if limited && !tour.legs.is_empty() {
        legs.budget
            .begin_improvement(started, request.budget_ms, request.iterations);
        legs.simplification.deadline = legs.budget.deadline();
        improve(&mut legs, request, entry, &mut found, &mut tour);
    }
    let (path, goal_indices) = joined(request.start, entry, &tour);
    let outcome = Outcome {
        order: tour.legs.iter().map(|leg| leg.goal).collect(),
        path,
        goal_indices,
        unreachable: (0..request.goals.len())
            .filter(|goal| !tour.visits.contains(goal))
            .collect(),
        iterations: stages.iterations(),
        nodes: stages.nodes,
        stages: stages.into_list(),
        time_ms: started.elapsed().as_secs_f64() * 1e3,
        first_ms: first.map(|first| first.as_secs_f64() * 1e3),
        start_blocked: false,
    };
    keep(state, request, entry, found, tour);
    state.random = random;
    outcome
}

/// The tour that comes without a budget, and what it was made from.
fn first_tour<F: Field>(
    legs: &mut LegSearch<F>,
    request: &Request,
    entry: Point,
    state: &mut ReplanState,
) -> (Tour, FirstSolution) {
    let goals = &request.goals;
    if request.algorithm == Algorithm::MultiGoal {
        let (any, settings) = (request.any_order, legs.simplification);
        if let Some(kept) = tour_repair::repair_tour(legs.field, state, entry, goals, any, settings)
        {
            let known = FirstSolution::known(entry, goals.len());
            return (Tour::known(entry, goals, kept), known);
        }
    }
    let best = request.algorithm == Algorithm::Best;
    if best && !(request.any_order && goals.len() > 1) {
        return (
            best::search(legs, request, entry),
            FirstSolution::known(entry, 0),
        );
    }
    let mut found = first_solution::search(legs, request, entry, state, Means::TreesAndLattices);
    let mut tour = tour_search::search(legs, &mut found, goals, request.any_order, state);
    if best {
        best::shorten(legs, &mut tour);
    }
    (tour, found)
}

/// The start, or the nearest point from which to begin where the start is a little too near an obstacle.
fn clear_start<F: Field>(field: &F, request: &Request) -> Option<Point> {
    if field.point_clear(request.start, request.radius) {
        Some(request.start)
    } else {
        start_recovery::outward(field, request.start, request.radius, request.start_recovery)
    }
}

/// The answer where the start cannot be left.
fn start_blocked(request: &Request, started: Instant) -> Outcome {
    Outcome {
        order: Vec::new(),
        path: vec![request.start],
        goal_indices: Vec::new(),
        unreachable: (0..request.goals.len()).collect(),
        iterations: 0,
        nodes: 1,
        stages: Vec::new(),
        time_ms: started.elapsed().as_secs_f64() * 1e3,
        first_ms: None,
        start_blocked: true,
    }
}

/// The whole path, and where in it each goal is.
fn joined(start: Point, entry: Point, tour: &Tour) -> (Vec<Point>, Vec<usize>) {
    let mut path = vec![start];
    if entry != start {
        path.push(entry);
    }
    let mut goal_indices = Vec::new();
    for leg in &tour.legs {
        for &p in &leg.path {
            if path.last() != Some(&p) {
                path.push(p);
            }
        }
        goal_indices.push(path.len() - 1);
    }
    (path, goal_indices)
}

/// Keeps for the next plan what may be of use to it.
fn keep(
    state: &mut ReplanState,
    request: &Request,
    entry: Point,
    found: FirstSolution,
    tour: Tour,
) {
    state.forget_other_goals(&request.goals);
    if let Some(tree) = found.tree {
        state.keep_tree(tree, &request.goals);
    }
    state.order = (tour.legs.iter())
        .map(|leg| name_of(request.goals[leg.goal]))
        .collect();
    for leg in tour.legs {
        let goal = |p: Point| (p != entry).then(|| name_of(p)).flatten();
        let (from, to) = (leg.path[0], leg.path[leg.path.len() - 1]);
        state.legs.insert((goal(from), goal(to)), leg.path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::path_length;
    use crate::map::circles::Circles;

    fn planned(request: &Request) -> Outcome {
        plan(&field(), request, &mut LatticeCache::default())
    }

    const ALGORITHMS: [Algorithm; 5] = [
        Algorithm::Best,
        Algorithm::Rrt,
        Algorithm::RrtStar,
        Algorithm::GoalSeeking,
        Algorithm::MultiGoal,
    ];

    fn field() -> Circles {
        let circles = [
            (2.0, 2.0, 0.7),
            (4.2, 3.0, 0.6),
            (1.0, 4.2, 0.5),
            (4.5, 1.0, 0.4),
        ];
        let obstacles = circles.map(|(x, y, r)| (Point::new(x, y), r));
        Circles::new(6.0, 6.0, obstacles.to_vec())
    }

    fn request(algorithm: Algorithm, iterations: Option<u64>) -> Request {
        Request {
            start: Point::new(0.5, 0.5),
            goals: [(5.5, 5.5), (0.5, 5.5), (3.0, 4.0)]
                .map(|(x, y)| Point::new(x, y))
                .to_vec(),
            algorithm,
            radius: 0.2,
            seed: 7,
            iterations,
            budget_ms: None,
            any_order: false,
            start_recovery: 0.0,
            corner_cost: 0.0,
            step: None,
            bias: None,
        }
    }

    #[test]
    fn every_algorithm_visits_the_goals_in_the_order_given_and_touches_nothing() {
        for algorithm in ALGORITHMS {
            let (field, request) = (field(), request(algorithm, None));
            let outcome = planned(&request);
            assert_eq!(outcome.order, [0, 1, 2]);
            assert_eq!(outcome.path[0], request.start);
            for (&goal, &index) in outcome.order.iter().zip(&outcome.goal_indices) {
                assert_eq!(outcome.path[index], request.goals[goal]);
            }
            assert!(
                (outcome.path.windows(2)).all(|edge| field.segment_clear(edge[0], edge[1], 0.2))
            );
        }
    }

    #[test]
    fn the_same_request_gives_the_same_path_and_more_iterations_a_shorter_one() {
        for algorithm in ALGORITHMS {
            let path = |iterations| planned(&request(algorithm, iterations)).path;
            assert_eq!(path(Some(500)), path(Some(500)));
            assert!(path_length(&path(Some(2_000))) <= path_length(&path(None)));
        }
    }

    #[test]
    fn in_any_order_the_tour_is_no_longer_than_in_the_order_given() {
        let any = Request {
            any_order: true,
            ..request(Algorithm::Best, Some(500))
        };
        let outcome = planned(&any);
        let given = planned(&request(Algorithm::Best, Some(500)));
        assert_eq!(outcome.order, [1, 2, 0]);
        assert!(path_length(&outcome.path) < path_length(&given.path));
    }

    #[test]
    fn a_blocked_start_and_a_blocked_goal_are_said() {
        let mut request = request(Algorithm::MultiGoal, None);
        request.goals[1] = Point::new(2.0, 2.0);
        let outcome = planned(&request);
        assert_eq!((outcome.unreachable, outcome.order), (vec![1], vec![0, 2]));
        request.start = Point::new(2.0, 2.0);
        let outcome = planned(&request);
        assert!(outcome.start_blocked && outcome.path.len() == 1);
    }

    #[test]
    fn on_an_unchanged_map_the_second_plan_is_the_first_ones_path() {
        let mut state = ReplanState::new(7);
        let request = request(Algorithm::MultiGoal, None);
        let first = replan(&field(), &request, &mut LatticeCache::default(), &mut state);
        let second = replan(&field(), &request, &mut LatticeCache::default(), &mut state);
        assert_eq!(first.path, second.path);
        assert_eq!(state.repair.pruned, 0);
    }
}
