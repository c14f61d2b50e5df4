//! Python's `NativeField`: a map to plan on.

use std::sync::{Mutex, PoisonError};

use numpy::{PyArray1, PyArray2, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::budget::Budget;
use crate::geometry::Point;
use crate::lattice::cache::LatticeCache;
use crate::map::circles::Circles;
use crate::map::field::Field;
use crate::map::grid::Grid;
use crate::planner::plan;
use crate::planner::request::Outcome;
use crate::python::arrays::{array_of, flat, points, require};
use crate::python::request::Settings;
use crate::random::Random;
use crate::tree::rrt::{GrowingTree, GrowthSettings};
use crate::tree::search_tree;

pub enum Map {
    Circles(Circles),
    Grid(Grid),
}

/// A map that the planner can ask: circles in a rectangle, or blocked cells.
#[pyclass(frozen)]
pub struct NativeField {
    pub map: Map,
    /// What plans on this map have found out about its lattices.
    lattices: Mutex<LatticeCache>,
}

impl NativeField {
    fn new(map: Map) -> Self {
        Self {
            map,
            lattices: Mutex::default(),
        }
    }

    /// Runs a plan with the lattices of this map; a plan that runs at the same time begins without them.
    pub fn with_lattices<T>(&self, run: impl FnOnce(&mut LatticeCache) -> T) -> T {
        let take = || self.lattices.lock().unwrap_or_else(PoisonError::into_inner);
        let mut lattices = std::mem::take(&mut *take());
        let result = run(&mut lattices);
        *take() = lattices;
        result
    }
}

/// The expression for whichever kind of map it is.
macro_rules! on {
    ($map:expr, $field:ident => $body:expr) => {
        match $map {
            Map::Circles($field) => $body,
            Map::Grid($field) => $body,
        }
    };
}

pub(crate) use on;

#[pymethods]
impl NativeField {
    /// `obstacles`: (N, 3) of x, y, radius in metres; the field is [0, width] × [0, height].
    #[staticmethod]
    fn circles(width: f64, height: f64, obstacles: PyReadonlyArray2<'_, f64>) -> PyResult<Self> {
        require(
            width.is_finite() && height.is_finite() && width > 0.0 && height > 0.0,
            "width and height must be positive",
        )?;
        require(
            obstacles.shape()[1] == 3,
            "obstacles must have three columns: x, y, radius",
        )?;
        let circles: Vec<(Point, f64)> = obstacles
            .as_array()
            .rows()
            .into_iter()
            .map(|row| (Point::new(row[0], row[1]), row[2]))
            .collect();
        require(
            circles
                .iter()
                .all(|(p, r)| p.x.is_finite() && p.y.is_finite() && r.is_finite() && *r >= 0.0),
            "obstacles must be finite, with a radius of at least 0",
        )?;
        Ok(Self::new(Map::Circles(Circles::new(
            width, height, circles,
        ))))
    }

    /// `blocked`: (rows, columns), row 0 at `origin_y`; not 0 is blocked.
    #[staticmethod]
    fn grid(
        blocked: PyReadonlyArray2<'_, u8>,
        resolution: f64,
        origin_x: f64,
        origin_y: f64,
    ) -> PyResult<Self> {
        require(
            resolution.is_finite() && resolution > 0.0,
            "resolution must be positive",
        )?;
        require(
            origin_x.is_finite() && origin_y.is_finite(),
            "origin must be finite",
        )?;
        let (cells, columns, rows) = flat(&blocked);
        require(columns > 0 && rows > 0, "the grid has no cells")?;
        Ok(Self::new(Map::Grid(Grid::new(
            cells,
            columns,
            rows,
            resolution,
            Point::new(origin_x, origin_y),
        ))))
    }

    /// (x_min, y_min, x_max, y_max).
    #[getter]
    fn bounds(&self) -> (f64, f64, f64, f64) {
        let (low, high) = on!(&self.map, field => field.bounds());
        (low.x, low.y, high.x, high.y)
    }

    /// Distance to the nearest obstacle or wall for each of the (N, 2) points.
    fn clearance<'py>(
        &self,
        py: Python<'py>,
        at: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let values = points(&at)?
            .into_iter()
            .map(|p| on!(&self.map, field => field.clearance(p)));
        Ok(PyArray1::from_iter(py, values))
    }

    /// True when a disc of `radius` swept from a to b stays inside and touches nothing.
    fn segment_clear(&self, a: (f64, f64), b: (f64, f64), radius: f64) -> bool {
        let (a, b) = (Point::new(a.0, a.1), Point::new(b.0, b.1));
        on!(&self.map, field => field.segment_clear(a, b, radius))
    }

    /// `settings`: a dict with every field of `request::Settings`.
    fn plan<'py>(
        &self,
        py: Python<'py>,
        start: (f64, f64),
        goals: PyReadonlyArray2<'py, f64>,
        algorithm: &str,
        seed: u64,
        settings: Settings,
    ) -> PyResult<Bound<'py, PyDict>> {
        let request = settings.request(start, &goals, algorithm, seed)?;
        let outcome = py.detach(|| {
            self.with_lattices(
                |lattices| on!(&self.map, field => plan::plan(field, &request, lattices)),
            )
        });
        answer(py, outcome)
    }

    /// Figure 3's tree alone: (nodes (N, 2), parents (-1 for the root), node per goal or -1, iterations).
    #[allow(clippy::too_many_arguments, clippy::type_complexity)]
    fn multi_goal_tree<'py>(
        &self,
        py: Python<'py>,
        start: (f64, f64),
        goals: PyReadonlyArray2<'py, f64>,
        radius: f64,
        seed: u64,
        iterations: u64,
        step: f64,
        bias: f64,
    ) -> PyResult<(Bound<'py, PyArray2<f64>>, Vec<i64>, Vec<i64>, u64)> {
        let goals = points(&goals)?;
        let growth = GrowthSettings { radius, step, bias };
        require(step.is_finite() && step > 0.0, "step must be positive")?;
        let mut random = Random::new(seed);
        let mut budget = Budget::new(iterations);
        let wanted = vec![true; goals.len()];
        let start = Point::new(start.0, start.1);
        let grown = on!(&self.map, field => {
            let mut grown = GrowingTree::new(field, start, &goals, growth);
            grown.grow(field, &goals, &wanted, growth, &mut random, &mut budget);
            grown
        });
        let signed = |index: usize| {
            if index == search_tree::ROOT {
                -1
            } else {
                index as i64
            }
        };
        Ok((
            array_of(py, &grown.tree.points)?,
            grown.tree.parents.iter().map(|&p| signed(p)).collect(),
            grown
                .reached
                .iter()
                .map(|node| node.map_or(-1, signed))
                .collect(),
            budget.used,
        ))
    }
}

/// An outcome as Python takes it.
pub fn answer<'py>(py: Python<'py>, outcome: Outcome) -> PyResult<Bound<'py, PyDict>> {
    let result = PyDict::new(py);
    result.set_item("order", outcome.order)?;
    result.set_item("path", array_of(py, &outcome.path)?)?;
    result.set_item("goal_indices", outcome.goal_indices)?;
    result.set_item("unreachable", outcome.unreachable)?;
    result.set_item("iterations", outcome.iterations)?;
    result.set_item("nodes", outcome.nodes)?;
    result.set_item("time_ms", outcome.time_ms)?;
    result.set_item("first_solution_ms", outcome.first_ms)?;
    let stages: Vec<(&str, f64, u64)> = (outcome.stages.iter())
        .map(|stage| (stage.name, 1e3 * stage.seconds, stage.iterations))
        .collect();
    result.set_item("stages", stages)?;
    result.set_item("start_blocked", outcome.start_blocked)?;
    Ok(result)
}
