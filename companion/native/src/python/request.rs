//! What Python asks of a planner, checked.

use numpy::PyReadonlyArray2;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::geometry::Point;
use crate::planner::request::{Algorithm, Request};
use crate::python::arrays::{points, require};

/// A plan's settings as Python hands them over.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Settings {
    robot_radius: f64,
    iterations: Option<u64>,
    budget_ms: Option<f64>,
    any_order: bool,
    start_recovery_m: f64,
    corner_cost_m: f64,
    step_m: Option<f64>,
    goal_bias: Option<f64>,
}

impl Settings {
    /// The request that they make with the rest.
    pub fn request(
        self,
        start: (f64, f64),
        goals: &PyReadonlyArray2<'_, f64>,
        algorithm: &str,
        seed: u64,
    ) -> PyResult<Request> {
        let request = Request {
            start: Point::new(start.0, start.1),
            goals: points(goals)?,
            algorithm: algorithm_of(algorithm)?,
            radius: self.robot_radius,
            seed,
            iterations: self.iterations,
            budget_ms: self.budget_ms,
            any_order: self.any_order,
            start_recovery: self.start_recovery_m,
            corner_cost: self.corner_cost_m,
            step: self.step_m,
            bias: self.goal_bias,
        };
        check(&request)?;
        Ok(request)
    }
}

fn algorithm_of(name: &str) -> PyResult<Algorithm> {
    match name {
        "best" => Ok(Algorithm::Best),
        "rrt" => Ok(Algorithm::Rrt),
        "rrt-star" => Ok(Algorithm::RrtStar),
        "goal-seeking" => Ok(Algorithm::GoalSeeking),
        "multi-goal" => Ok(Algorithm::MultiGoal),
        _ => Err(PyValueError::new_err(format!("unknown algorithm {name:?}"))),
    }
}

fn check(request: &Request) -> PyResult<()> {
    let finite = |p: &Point| p.x.is_finite() && p.y.is_finite();
    let positive = |value: Option<f64>| value.is_none_or(|v| v.is_finite() && v > 0.0);
    require(finite(&request.start), "the start is not finite")?;
    require(request.goals.iter().all(finite), "a goal is not finite")?;
    require(
        request.radius.is_finite() && request.radius >= 0.0,
        "the robot's radius must be at least 0",
    )?;
    require(positive(request.step), "the step must be positive")?;
    require(
        request.bias.is_none_or(|b| (0.0..=1.0).contains(&b)),
        "the bias must be between 0 and 1",
    )?;
    require(
        request.budget_ms.is_none_or(|b| b.is_finite() && b >= 0.0),
        "the time budget must be at least 0",
    )?;
    require(
        request.start_recovery.is_finite()
            && request.corner_cost.is_finite()
            && request.corner_cost >= 0.0,
        "start recovery and corner cost must be finite",
    )
}
