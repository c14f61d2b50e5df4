//! A first path to every goal that has one: by trees, and by lattices where trees find none.

use std::time::Instant;

use crate::geometry::Point;
use crate::lattice::feasibility::Feasibility;
use crate::lattice::graph::Lattice;
use crate::map::field::Field;
use crate::path::tour::straight_distances;
use crate::path::visit_order;
use crate::planner::connect_goals;
use crate::planner::leg_search::LegSearch;
use crate::planner::request::{Algorithm, Request};
use crate::replan::state::ReplanState;
use crate::tree::rrt::GrowingTree;
use crate::tree::rrt_star::RrtStar;

/// Tree extensions for each goal after which the search for a first solution is given up.
pub const MAX_EXTENSIONS: u64 = 50_000;
/// As many when no lattice has found a path either: what is left are passages finer than its spacing.
pub const MAX_DOUBTFUL_EXTENSIONS: u64 = 10_000;
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
    /// RRT*: per visit the tree, where it has reached the goal.
    pub stars: Vec<Option<RrtStar>>,
    /// A path is not a tree's alone.
    pub by_lattice: bool,
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
            stars: Vec::new(),
            by_lattice: false,
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

/// Who looks for a first path.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Means {
    /// Trees, and lattices where they find none.
    TreesAndLattices,
    /// Trees alone: for a goal that they miss there is a path already.
    Trees,
}

/// A first path to every goal that has one. `state` holds the tree of the plan before.
pub fn search<F: Field>(
    legs: &mut LegSearch<F>,
    request: &Request,
    start: Point,
    state: &mut ReplanState,
    means: Means,
) -> FirstSolution {
    let goals = &request.goals;
    let wanted: Vec<bool> = (goals.iter())
        .map(|&goal| legs.field.point_clear(goal, request.radius))
        .collect();
    match request.algorithm {
        Algorithm::MultiGoal | Algorithm::Best => {
            let settings = legs.simplification;
            let tree = state.take_tree(legs.field, start, goals, legs.growth, settings);
            one_tree(legs, goals, start, wanted, tree, means)
        }
        _ => staged(legs, request, start, &wanted, means),
    }
}

/// Figure 3: one tree from the start that seeks all goals; the lattice settles what the tree has not reached.
fn one_tree<F: Field>(
    legs: &mut LegSearch<F>,
    goals: &[Point],
    start: Point,
    mut wanted: Vec<bool>,
    mut tree: GrowingTree,
    means: Means,
) -> FirstSolution {
    let (field, radius) = (legs.field, legs.growth.radius);
    let most = match means {
        Means::TreesAndLattices => MAX_FIRST_EXTENSIONS,
        Means::Trees => MAX_EXTENSIONS,
    };
    legs.grow(&mut tree, goals, &wanted, most);
    let before = tree.tree.points.len();
    let began = Instant::now();
    let lattice = match means {
        Means::TreesAndLattices => {
            connect_goals::connect_goals(field, &mut tree, goals, &mut wanted, radius)
        }
        Means::Trees => None,
    };
    if let Some(lattice) = &lattice {
        legs.stages.record("lattice", began, lattice.known_cells());
        legs.stages.nodes += tree.tree.points.len() - before + lattice.known_cells() as usize;
        legs.grow(&mut tree, goals, &wanted, MAX_DOUBTFUL_EXTENSIONS);
    }
    let visits: Vec<usize> = (0..goals.len())
        .filter(|&goal| tree.reached[goal].is_some())
        .collect();
    FirstSolution {
        start,
        visits,
        paths: Vec::new(),
        tree: Some(tree),
        by_lattice: lattice.is_some(),
        lattice,
        stars: Vec::new(),
    }
}

/// Section 3.5: a tree to the first goal, which then is the start of a new tree to the next.
fn staged<F: Field>(
    legs: &mut LegSearch<F>,
    request: &Request,
    start: Point,
    wanted: &[bool],
    means: Means,
) -> FirstSolution {
    let goals = &request.goals;
    let mut sequence: Vec<usize> = (0..goals.len()).filter(|&goal| wanted[goal]).collect();
    if request.any_order {
        let mut stops = vec![start];
        stops.extend(sequence.iter().map(|&goal| goals[goal]));
        sequence = (visit_order::order(&straight_distances(&stops)).iter())
            .map(|&stop| sequence[stop - 1])
            .collect();
    }
    let mut found = FirstSolution::known(start, 0);
    let mut at = start;
    for goal in sequence {
        let (path, star, by_lattice) = single(legs, request.algorithm, (at, goals[goal]), means);
        found.by_lattice |= by_lattice;
        if let Some(path) = path {
            at = goals[goal];
            found.visits.push(goal);
            found.paths.push(path);
            found.stars.push(star);
        }
    }
    found
}

/// One tree, one goal; the tree where it is RRT*'s, and whether the tree gave up. Gives up early when a flood proves that
/// there is no path; falls back on the lattice's path.
fn single<F: Field>(
    legs: &mut LegSearch<F>,
    algorithm: Algorithm,
    (start, goal): (Point, Point),
    means: Means,
) -> (Option<Vec<Point>>, Option<RrtStar>, bool) {
    let (field, growth) = (legs.field, legs.growth);
    let mut known = None;
    for most in [MAX_FIRST_EXTENSIONS, MAX_EXTENSIONS] {
        let most = match known {
            Some(Feasibility::Unknown) => MAX_DOUBTFUL_EXTENSIONS,
            _ => most,
        };
        if algorithm == Algorithm::RrtStar {
            let mut star = RrtStar::new(field, start, goal, growth);
            let (began, used) = (Instant::now(), legs.budget.used);
            let whole = legs.budget.capped(most);
            star.solve(field, growth, legs.random, legs.budget);
            legs.budget.restore(whole);
            legs.stages.record("tree", began, legs.budget.used - used);
            legs.stages.nodes += star.nodes();
            if let Some(path) = star.path() {
                return (Some(path), Some(star), false);
            }
        } else {
            let mut tree = GrowingTree::new(field, start, &[goal], growth);
            legs.grow(&mut tree, &[goal], &[true], most);
            if let Some(node) = tree.reached[0] {
                return (Some(tree.tree.path_to(node)), None, false);
            }
        }
        if known.is_none() && means == Means::TreesAndLattices {
            known = Some(legs.first_lattice_path(start, goal));
            if known == Some(Feasibility::Infeasible) {
                break;
            }
        }
    }
    // The tree gave up where the lattice knows a path: that is better than none.
    match known {
        Some(Feasibility::Path(path)) => (Some(path), None, true),
        _ => (None, None, true),
    }
}
