//! A first path to every goal that has one: by trees, and by lattices where trees find none.

use crate::budget::Budget;
use crate::geometry::Point;
use crate::lattice::feasibility::{self, Feasibility};
use crate::lattice::graph::Lattice;
use crate::map::field::Field;
use crate::path::simplify::Simplification;
use crate::path::tour::straight_distances;
use crate::path::visit_order;
use crate::planner::connect_goals;
use crate::planner::request::{Algorithm, Request};
use crate::random::Random;
use crate::replan::state::ReplanState;
use crate::tree::rrt::{GrowingTree, GrowthSettings};
use crate::tree::rrt_star;

/// Tree extensions for each goal after which the search for a first solution is given up.
pub const MAX_EXTENSIONS: u64 = 50_000;
/// As many when no lattice has found a path either: what is left are passages finer than its spacing.
const MAX_DOUBTFUL_EXTENSIONS: u64 = 10_000;
/// Tree extensions before the lattice is asked which goals are possible at all.
const MAX_FIRST_EXTENSIONS: u64 = 1_000;

/// What the first search found.
pub struct FirstSolution {
    /// Where the tour begins.
    pub start: Point,
    /// Goals with a path, in the order in which they were asked for or, staged, visited.
    pub visits: Vec<usize>,
    /// Staged: per visit the path from the visit before.
    pub paths: Vec<Vec<Point>>,
    /// The one tree; none when the search was staged.
    pub tree: Option<GrowingTree>,
    /// The coarsest lattice, if one was searched: the map is such that trees have a hard time.
    pub lattice: Option<Lattice>,
    /// Nodes that were made.
    pub nodes: usize,
}

impl FirstSolution {
    /// All of so many `goals`, with nothing searched: an old tour leads to them.
    pub fn known(start: Point, goals: usize) -> Self {
        Self {
            start,
            visits: (0..goals).collect(),
            paths: Vec::new(),
            tree: None,
            lattice: None,
            nodes: 0,
        }
    }

    /// The path through the tree between two stops (0 is the start, the others are visits); clear, but not short.
    pub fn tree_path(&self, tree: &GrowingTree, from: usize, to: usize) -> Vec<Point> {
        let node = |stop: usize| match stop {
            0 => 0,
            // Only goals that the tree has reached are visited.
            stop => tree.reached[self.visits[stop - 1]].unwrap_or(0),
        };
        tree.tree.path_between(node(from), node(to))
    }
}

/// A first path to every goal that has one. `state` holds the tree of the plan before.
pub fn search<F: Field>(
    field: &F,
    request: &Request,
    start: Point,
    state: &mut ReplanState,
    simplification: Simplification,
    random: &mut Random,
    budget: &mut Budget,
) -> FirstSolution {
    let goals = &request.goals;
    let growth = request.growth(field);
    let wanted: Vec<bool> = (goals.iter())
        .map(|&goal| field.point_clear(goal, request.radius))
        .collect();
    if request.algorithm == Algorithm::MultiGoal {
        let tree = state.take_tree(field, start, goals, growth, simplification);
        one_tree(field, request, start, wanted, tree, random, budget)
    } else {
        staged(field, request, start, &wanted, random, budget)
    }
}

/// Figure 3: one tree from the start that seeks all goals; the lattice settles what the tree has not reached.
fn one_tree<F: Field>(
    field: &F,
    request: &Request,
    start: Point,
    mut wanted: Vec<bool>,
    mut tree: GrowingTree,
    random: &mut Random,
    budget: &mut Budget,
) -> FirstSolution {
    let goals = &request.goals;
    let growth = request.growth(field);
    let whole = budget.capped(MAX_FIRST_EXTENSIONS);
    tree.grow(field, goals, &wanted, growth, random, budget);
    budget.restore(whole);
    let lattice = connect_goals::connect_goals(field, &mut tree, goals, &mut wanted, growth.radius);
    let whole = budget.capped(MAX_DOUBTFUL_EXTENSIONS);
    tree.grow(field, goals, &wanted, growth, random, budget);
    budget.restore(whole);
    let visits: Vec<usize> = (0..goals.len())
        .filter(|&goal| tree.reached[goal].is_some())
        .collect();
    FirstSolution {
        start,
        visits,
        paths: Vec::new(),
        nodes: tree.tree.points.len(),
        tree: Some(tree),
        lattice,
    }
}

/// Section 3.5: a tree to the first goal, which then is the start of a new tree to the next.
fn staged<F: Field>(
    field: &F,
    request: &Request,
    start: Point,
    wanted: &[bool],
    random: &mut Random,
    budget: &mut Budget,
) -> FirstSolution {
    let goals = &request.goals;
    let growth = request.growth(field);
    let mut sequence: Vec<usize> = (0..goals.len()).filter(|&goal| wanted[goal]).collect();
    if request.any_order {
        let mut stops = vec![start];
        stops.extend(sequence.iter().map(|&goal| goals[goal]));
        sequence = (visit_order::order(&straight_distances(&stops)).iter())
            .map(|&stop| sequence[stop - 1])
            .collect();
    }
    let mut found = FirstSolution {
        start,
        visits: Vec::new(),
        paths: Vec::new(),
        nodes: 0,
        tree: None,
        lattice: None,
    };
    let mut at = start;
    for goal in sequence {
        let (path, nodes) = single(
            field,
            request.algorithm,
            (at, goals[goal]),
            growth,
            random,
            budget,
        );
        found.nodes += nodes;
        if let Some(path) = path {
            at = goals[goal];
            found.visits.push(goal);
            found.paths.push(path);
        }
    }
    found
}

/// One tree, one goal; and how many nodes were made. Gives up early when a flood proves that there is no path; falls back
/// on the lattice's path.
fn single<F: Field>(
    field: &F,
    algorithm: Algorithm,
    (start, goal): (Point, Point),
    growth: GrowthSettings,
    random: &mut Random,
    budget: &mut Budget,
) -> (Option<Vec<Point>>, usize) {
    let goals = [goal];
    let mut nodes = 0;
    let mut known = None;
    for most in [MAX_FIRST_EXTENSIONS, MAX_EXTENSIONS] {
        let whole = budget.capped(match known {
            Some(Feasibility::Unknown) => MAX_DOUBTFUL_EXTENSIONS,
            _ => most,
        });
        let (path, made) = if algorithm == Algorithm::RrtStar {
            rrt_star::plan(field, start, goal, growth, 0, random, budget)
        } else {
            let mut tree = GrowingTree::new(field, start, &goals, growth);
            tree.grow(field, &goals, &[true], growth, random, budget);
            let path = tree.reached[0].map(|node| tree.tree.path_to(node));
            (path, tree.tree.points.len())
        };
        budget.restore(whole);
        nodes += made;
        if path.is_some() {
            return (path, nodes);
        }
        if known.is_none() {
            known = Some(feasibility::first_path(field, start, goal, growth.radius));
            if known == Some(Feasibility::Infeasible) {
                break;
            }
        }
    }
    // The tree gave up where the lattice knows a path: that is better than none.
    match known {
        Some(Feasibility::Path(path)) => (Some(path), nodes),
        _ => (None, nodes),
    }
}
