//! One plan: from a request to a path through all goals, then better for as long as the budget lasts.

use std::time::Instant;

use crate::again;
use crate::budget::Budget;
use crate::escape;
use crate::field::Field;
use crate::geometry::{distance, Point};
use crate::hang;
use crate::lattice;
use crate::memory::{name_of, Memory, Repair};
use crate::order;
use crate::random::Random;
use crate::rrt::{Grown, Growth};
use crate::shorten::{self, Shortening};
use crate::star;
use crate::tour::{Search, Stops, Tour};

#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Algorithm {
    Rrt,
    RrtStar,
    GoalSeeking,
    MultiGoal,
}

pub struct Request {
    pub start: Point,
    pub goals: Vec<Point>,
    pub algorithm: Algorithm,
    pub radius: f64,
    pub seed: u64,
    /// Total of tree extensions and shortcut attempts until which planning goes on improving.
    pub iterations: Option<u64>,
    pub budget_ms: Option<f64>,
    pub any_order: bool,
    pub start_escape: f64,
    pub corner_cost: f64,
    pub step: Option<f64>,
    pub bias: Option<f64>,
}

pub struct Outcome {
    /// Goals in order of visit.
    pub order: Vec<usize>,
    pub path: Vec<Point>,
    /// For each visited goal, its index in `path`.
    pub goal_indices: Vec<usize>,
    pub unreachable: Vec<usize>,
    pub iterations: u64,
    pub nodes: usize,
    pub time_ms: f64,
    pub first_ms: Option<f64>,
    pub start_blocked: bool,
}

/// Iterations for each goal after which the search for a first solution is given up.
const PATIENCE: u64 = 50_000;
/// As many when the lattice has found no way either: what is left are passages finer than its spacing.
const DOUBT: u64 = 10_000;
/// Tree extensions before the lattice is asked which goals are possible at all.
const FIRST_TRY: u64 = 1_000;

impl Request {
    /// The settings of tree growth that this request and this field imply.
    pub fn growth<F: Field>(&self, field: &F) -> Growth {
        let (low, high) = field.bounds();
        let bias = match self.algorithm {
            Algorithm::Rrt => 0.0,
            Algorithm::RrtStar => 0.05,
            Algorithm::GoalSeeking | Algorithm::MultiGoal => 0.3,
        };
        Growth {
            radius: self.radius,
            step: self.step.unwrap_or(0.1 * distance(low, high)),
            bias: self.bias.unwrap_or(bias),
        }
    }
}

pub fn plan<F: Field>(field: &F, request: &Request) -> Outcome {
    plan_again(field, request, &mut Memory::new(request.seed))
}

/// The same, going on from what `memory` holds of the plan before. Only the one tree of `MultiGoal` is kept.
pub fn plan_again<F: Field>(field: &F, request: &Request, memory: &mut Memory) -> Outcome {
    let started = Instant::now();
    let unlimited = request.iterations.is_none() && request.budget_ms.is_none();
    // The first solution is not starved by a small budget, which is about how long to go on improving.
    let goals = request.goals.len().max(1) as u64;
    let mut budget = Budget::new(PATIENCE * goals);
    let mut random = memory.random.clone();
    let growth = request.growth(field);
    let shortening = Shortening {
        radius: request.radius,
        corner_cost: request.corner_cost,
        least_move: shorten::LEAST_MOVE,
        deadline: None,
    };
    let mut outcome = Outcome {
        order: Vec::new(),
        path: vec![request.start],
        goal_indices: Vec::new(),
        unreachable: Vec::new(),
        iterations: 0,
        nodes: 1,
        time_ms: 0.0,
        first_ms: None,
        start_blocked: false,
    };
    let entry = if field.point_clear(request.start, request.radius) {
        Some(request.start)
    } else {
        escape::outward(field, request.start, request.radius, request.start_escape)
    };
    let Some(entry) = entry else {
        outcome.start_blocked = true;
        outcome.unreachable = (0..request.goals.len()).collect();
        outcome.time_ms = started.elapsed().as_secs_f64() * 1e3;
        return outcome;
    };
    memory.repair = Repair::default();
    memory.mender.begin(field, request.radius);
    let kept = if request.algorithm == Algorithm::MultiGoal {
        let any = request.any_order;
        again::mended_tour(field, memory, entry, &request.goals, any, shortening)
    } else {
        None
    };
    let mut stops = if kept.is_some() {
        Stops::mended(entry, goals as usize)
    } else {
        searched(
            field,
            request,
            entry,
            memory,
            shortening,
            &mut random,
            &mut budget,
        )
    };
    outcome.nodes = stops.nodes;
    outcome.unreachable = (0..request.goals.len())
        .filter(|goal| !stops.visits.contains(goal))
        .collect();
    // There is a way to every goal that has one: what comes from here on only makes it better.
    budget.end_after(started, request.budget_ms);
    let mut search = Search {
        field,
        growth,
        shortening: Shortening {
            deadline: budget.deadline(),
            ..shortening
        },
        random: &mut random,
        budget: &mut budget,
    };
    let mut tour = match kept {
        Some(legs) => Tour::mended(entry, &request.goals, legs),
        None => search.tour(&mut stops, &request.goals, request.any_order, memory),
    };
    if !tour.legs.is_empty() {
        outcome.first_ms = Some(tour.first.duration_since(started).as_secs_f64() * 1e3);
        if !unlimited {
            let limit = request.iterations.unwrap_or(u64::MAX);
            search.budget.improve_until(limit);
            search.improve(&mut tour, request.any_order);
        }
    }
    outcome.nodes += tour.nodes;
    if entry != request.start {
        outcome.path.push(entry);
    }
    for leg in &tour.legs {
        for &p in &leg.path {
            if outcome.path.last() != Some(&p) {
                outcome.path.push(p);
            }
        }
        outcome.order.push(leg.goal);
        outcome.goal_indices.push(outcome.path.len() - 1);
    }
    memory.forget_other_goals(&request.goals);
    if let Some(grown) = stops.grown {
        memory.keep_tree(grown, &request.goals);
    }
    for leg in &tour.legs {
        let goal = |p: Point| (p != entry).then(|| name_of(p)).flatten();
        let (from, to) = (leg.path[0], leg.path[leg.path.len() - 1]);
        memory.legs.insert((goal(from), goal(to)), leg.path.clone());
    }
    memory.order = (outcome.order.iter())
        .map(|&goal| name_of(request.goals[goal]))
        .collect();
    memory.random = random;
    outcome.iterations = budget.used;
    outcome.time_ms = started.elapsed().as_secs_f64() * 1e3;
    outcome
}

/// A first way to every goal that has one.
fn searched<F: Field>(
    field: &F,
    request: &Request,
    start: Point,
    memory: &mut Memory,
    shortening: Shortening,
    random: &mut Random,
    budget: &mut Budget,
) -> Stops {
    let goals = &request.goals;
    let growth = request.growth(field);
    let wanted: Vec<bool> = (goals.iter())
        .map(|&goal| field.point_clear(goal, request.radius))
        .collect();
    if request.algorithm == Algorithm::MultiGoal {
        let grown = memory.take_tree(field, start, goals, growth, shortening);
        one_tree(field, request, start, wanted, grown, random, budget)
    } else {
        staged(field, request, start, &wanted, growth, random, budget)
    }
}

/// Figure 3: one tree from the start that seeks all goals; the lattice settles what the tree has not reached.
fn one_tree<F: Field>(
    field: &F,
    request: &Request,
    start: Point,
    mut wanted: Vec<bool>,
    mut grown: Grown,
    random: &mut Random,
    budget: &mut Budget,
) -> Stops {
    let goals = &request.goals;
    let growth = request.growth(field);
    let whole = budget.capped(FIRST_TRY);
    grown.grow(field, goals, &wanted, growth, random, budget);
    budget.restore(whole);
    let lattice = hang::hang(field, &mut grown, goals, &mut wanted, growth.radius);
    let whole = budget.capped(DOUBT);
    grown.grow(field, goals, &wanted, growth, random, budget);
    budget.restore(whole);
    let visits: Vec<usize> = (0..goals.len())
        .filter(|&goal| grown.reached[goal].is_some())
        .collect();
    Stops {
        start,
        visits,
        ways: Vec::new(),
        nodes: grown.tree.points.len(),
        grown: Some(grown),
        lattice,
    }
}

/// Section 3.5: a tree to the first goal, which then is the start of a new tree to the next.
fn staged<F: Field>(
    field: &F,
    request: &Request,
    start: Point,
    wanted: &[bool],
    growth: Growth,
    random: &mut Random,
    budget: &mut Budget,
) -> Stops {
    let goals = &request.goals;
    let mut sequence: Vec<usize> = (0..goals.len()).filter(|&goal| wanted[goal]).collect();
    if request.any_order {
        let mut stops = vec![start];
        stops.extend(sequence.iter().map(|&goal| goals[goal]));
        let legs: Vec<Vec<f64>> = stops
            .iter()
            .map(|&a| stops.iter().map(|&b| distance(a, b)).collect())
            .collect();
        sequence = order::order(&legs)
            .iter()
            .map(|&stop| sequence[stop - 1])
            .collect();
    }
    let mut stops = Stops {
        start,
        visits: Vec::new(),
        ways: Vec::new(),
        nodes: 0,
        grown: None,
        lattice: None,
    };
    let mut at = start;
    for goal in sequence {
        let (path, nodes) = single(field, request, at, goals[goal], growth, random, budget);
        stops.nodes += nodes;
        if let Some(path) = path {
            at = goals[goal];
            stops.visits.push(goal);
            stops.ways.push(path);
        }
    }
    stops
}

/// One tree, one goal. Gives up early when a flood proves that there is no way; falls back on the lattice's way.
fn single<F: Field>(
    field: &F,
    request: &Request,
    start: Point,
    goal: Point,
    growth: Growth,
    random: &mut Random,
    budget: &mut Budget,
) -> (Option<Vec<Point>>, usize) {
    let goals = [goal];
    let mut nodes = 0;
    let mut known = None;
    for patience in [FIRST_TRY, PATIENCE] {
        let whole = budget.capped(match known {
            Some(Err(_)) => DOUBT,
            _ => patience,
        });
        let (path, made) = if request.algorithm == Algorithm::RrtStar {
            star::plan(field, start, goal, growth, 0, random, budget)
        } else {
            let mut grown = Grown::new(field, start, &goals, growth);
            grown.grow(field, &goals, &[true], growth, random, budget);
            let path = grown.reached[0].map(|node| grown.tree.path_to(node));
            (path, grown.tree.points.len())
        };
        budget.restore(whole);
        nodes += made;
        if path.is_some() {
            return (path, nodes);
        }
        if known.is_none() {
            known = Some(lattice::way(field, start, goal, growth.radius));
            if known == Some(Err(false)) {
                break;
            }
        }
    }
    // The tree ran out of patience where the lattice knows a way: the lattice's way is better than none.
    (known.and_then(Result::ok), nodes)
}
