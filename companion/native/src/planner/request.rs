//! What a planner is asked, and what it answers.

use crate::geometry::{distance, Point};
use crate::map::field::Field;
use crate::planner::stages::Stage;
use crate::tree::rrt::GrowthSettings;

/// Length of a tree's step as a share of the map's diagonal, unless the request says otherwise.
const STEP_SHARE: f64 = 0.1;
/// Share of the samples that are the goal, for RRT*: enough to find it, little enough to explore.
const RRT_STAR_GOAL_BIAS: f64 = 0.05;
/// The same for trees that seek goals (section 3.4 and figure 3). Plain RRT has none.
const GOAL_SEEKING_BIAS: f64 = 0.3;

/// How to search: the four algorithms of the paper as they are, and the best of everything.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Algorithm {
    /// A lattice and trees, then whatever makes the tour shorter.
    Best,
    /// One tree a goal, no goal bias.
    Rrt,
    /// One RRT* a goal.
    RrtStar,
    /// One tree a goal, with a goal bias.
    GoalSeeking,
    /// One tree towards all goals (figure 3).
    MultiGoal,
}

/// A question to the planner; metres.
pub struct Request {
    /// Where the robot is.
    pub start: Point,
    /// Where it should go.
    pub goals: Vec<Point>,
    /// How to search.
    pub algorithm: Algorithm,
    /// Radius of the robot.
    pub radius: f64,
    /// Fixes every random choice.
    pub seed: u64,
    /// Tree extensions and shortcut attempts beyond the answer that comes without a budget.
    pub iterations: Option<u64>,
    /// Milliseconds by the clock, of the whole plan, until which the answer is improved.
    pub budget_ms: Option<f64>,
    /// The planner chooses the order of the goals.
    pub any_order: bool,
    /// How far a start that is too near an obstacle may be moved away from it first.
    pub start_recovery: f64,
    /// Metres that one corner less is worth.
    pub corner_cost: f64,
    /// Δt of eq. 13, unless the map decides.
    pub step: Option<f64>,
    /// Share of the samples that are a goal, unless the algorithm decides.
    pub bias: Option<f64>,
}

/// The planner's answer.
pub struct Outcome {
    /// Goals in order of visit.
    pub order: Vec<usize>,
    /// From the start through all goals that can be reached.
    pub path: Vec<Point>,
    /// For each visited goal, its index in `path`.
    pub goal_indices: Vec<usize>,
    /// Goals that cannot be reached.
    pub unreachable: Vec<usize>,
    /// Tree extensions, shortcut attempts and expanded cells.
    pub iterations: u64,
    /// Nodes of all trees, and labelled cells.
    pub nodes: usize,
    /// What ran.
    pub stages: Vec<Stage>,
    /// Milliseconds by the clock.
    pub time_ms: f64,
    /// The same until the first valid tour was known, if there is one.
    pub first_ms: Option<f64>,
    /// The start is too near an obstacle to be left.
    pub start_blocked: bool,
}

impl Request {
    /// How trees grow for this request on this map.
    pub fn growth<F: Field>(&self, field: &F) -> GrowthSettings {
        let (low, high) = field.bounds();
        let bias = match self.algorithm {
            Algorithm::Rrt => 0.0,
            Algorithm::RrtStar => RRT_STAR_GOAL_BIAS,
            Algorithm::Best | Algorithm::GoalSeeking | Algorithm::MultiGoal => GOAL_SEEKING_BIAS,
        };
        GrowthSettings {
            radius: self.radius,
            step: self.step.unwrap_or(STEP_SHARE * distance(low, high)),
            bias: self.bias.unwrap_or(bias),
        }
    }
}
