//! Python's door to the planner's inner loops: arrays in, arrays out, every value checked here.

mod budget;
mod circles;
mod connect;
mod dijkstra;
mod escape;
mod field;
mod geometry;
mod grid;
mod lattice;
mod order;
mod planner;
mod random;
mod rrt;
mod shorten;
mod star;
mod tour;
mod transform;
mod tree;
mod views;

use numpy::{PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use budget::Budget;
use circles::Circles;
use field::Field;
use geometry::Point;
use grid::Grid;
use planner::{Algorithm, Request};
use random::Random;
use rrt::Grown;

enum Map {
    Circles(Circles),
    Grid(Grid),
}

/// A map that the planner can ask: circles in a rectangle, or blocked cells.
#[pyclass(frozen)]
struct NativeField {
    map: Map,
}

fn flat<'py, T: numpy::Element + Copy>(array: &PyReadonlyArray2<'py, T>) -> (Vec<T>, usize, usize) {
    let shape = array.shape();
    (
        array.as_array().iter().copied().collect(),
        shape[1],
        shape[0],
    )
}

fn points(array: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<Point>> {
    if array.shape()[1] != 2 {
        return Err(PyValueError::new_err("points must have two columns"));
    }
    Ok(array
        .as_array()
        .rows()
        .into_iter()
        .map(|row| Point::new(row[0], row[1]))
        .collect())
}

fn require(condition: bool, message: &str) -> PyResult<()> {
    if condition {
        Ok(())
    } else {
        Err(PyValueError::new_err(message.to_owned()))
    }
}

fn rows_of(path: &[Point]) -> Vec<Vec<f64>> {
    path.iter().map(|p| vec![p.x, p.y]).collect()
}

/// (N, 2) array, also for N = 0.
fn array_of<'py>(py: Python<'py>, path: &[Point]) -> PyResult<Bound<'py, PyArray2<f64>>> {
    if path.is_empty() {
        return Ok(PyArray2::zeros(py, [0, 2], false));
    }
    PyArray2::from_vec2(py, &rows_of(path))
        .map_err(|error| PyValueError::new_err(error.to_string()))
}

macro_rules! on {
    ($map:expr, $field:ident => $body:expr) => {
        match $map {
            Map::Circles($field) => $body,
            Map::Grid($field) => $body,
        }
    };
}

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
        Ok(Self {
            map: Map::Circles(Circles {
                width,
                height,
                obstacles: circles,
            }),
        })
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
        Ok(Self {
            map: Map::Grid(Grid::new(
                cells,
                columns,
                rows,
                resolution,
                Point::new(origin_x, origin_y),
            )),
        })
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

    #[allow(clippy::too_many_arguments)]
    #[pyo3(signature = (start, goals, algorithm, radius, seed, iterations, budget_ms, any_order, start_escape,
                        corner_cost, step=None, bias=None))]
    fn plan<'py>(
        &self,
        py: Python<'py>,
        start: (f64, f64),
        goals: PyReadonlyArray2<'py, f64>,
        algorithm: &str,
        radius: f64,
        seed: u64,
        iterations: Option<u64>,
        budget_ms: Option<f64>,
        any_order: bool,
        start_escape: f64,
        corner_cost: f64,
        step: Option<f64>,
        bias: Option<f64>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let request = Request {
            start: Point::new(start.0, start.1),
            goals: points(&goals)?,
            algorithm: algorithm_of(algorithm)?,
            radius,
            seed,
            iterations,
            budget_ms,
            any_order,
            start_escape,
            corner_cost,
            step,
            bias,
        };
        check(&request)?;
        let map = &self.map;
        let outcome = py.detach(|| on!(map, field => planner::plan(field, &request)));
        let result = PyDict::new(py);
        result.set_item("order", outcome.order)?;
        result.set_item("path", array_of(py, &outcome.path)?)?;
        result.set_item("goal_indices", outcome.goal_indices)?;
        result.set_item("unreachable", outcome.unreachable)?;
        result.set_item("iterations", outcome.iterations)?;
        result.set_item("nodes", outcome.nodes)?;
        result.set_item("time_ms", outcome.time_ms)?;
        result.set_item("first_solution_ms", outcome.first_ms)?;
        result.set_item("start_blocked", outcome.start_blocked)?;
        Ok(result)
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
        let growth = rrt::Growth { radius, step, bias };
        require(step.is_finite() && step > 0.0, "step must be positive")?;
        let mut random = Random::new(seed);
        let mut budget = Budget::new(iterations);
        let wanted = vec![true; goals.len()];
        let start = Point::new(start.0, start.1);
        let grown = on!(&self.map, field => {
            let mut grown = Grown::new(field, start, &goals, growth);
            grown.grow(field, &goals, &wanted, growth, &mut random, &mut budget);
            grown
        });
        let signed = |index: usize| {
            if index == tree::ROOT {
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

fn algorithm_of(name: &str) -> PyResult<Algorithm> {
    match name {
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
        request.start_escape.is_finite()
            && request.corner_cost.is_finite()
            && request.corner_cost >= 0.0,
        "start escape and corner cost must be finite",
    )
}

/// Metres from the centre of each cell to the nearest blocked cell's square; 1e9 when nothing is blocked.
#[pyfunction]
fn clearance_map<'py>(
    py: Python<'py>,
    blocked: PyReadonlyArray2<'py, u8>,
    resolution: f64,
) -> PyResult<Bound<'py, PyArray2<f32>>> {
    require(
        resolution.is_finite() && resolution > 0.0,
        "resolution must be positive",
    )?;
    let (cells, columns, rows) = flat(&blocked);
    require(columns > 0 && rows > 0, "the grid has no cells")?;
    let grid = Grid::new(cells, columns, rows, resolution, Point::new(0.0, 0.0));
    reshaped(py, &grid.clearance, columns)
}

/// Travel distance in metres over free cells from `start` = (column, row); infinite where there is no way.
#[pyfunction]
fn distance_field<'py>(
    py: Python<'py>,
    blocked: PyReadonlyArray2<'py, u8>,
    start: (usize, usize),
    resolution: f64,
) -> PyResult<Bound<'py, PyArray2<f32>>> {
    let (cells, columns, rows) = flat(&blocked);
    require(
        start.0 < columns && start.1 < rows,
        "the start lies outside the grid",
    )?;
    let index = start.1 * columns + start.0;
    let distances = dijkstra::distances(&cells, columns, rows, index, resolution);
    reshaped(py, &distances, columns)
}

/// How much unseen ground a camera would see: its footprint at a set of headings, prepared once.
#[pyclass(frozen)]
struct Views {
    views: views::Views,
}

#[pymethods]
impl Views {
    /// `footprint`: (M, 2) convex polygon in base_link, metres; `headings`: (K,) radians.
    #[new]
    fn new(
        footprint: PyReadonlyArray2<'_, f64>,
        headings: PyReadonlyArray1<'_, f64>,
        resolution: f64,
    ) -> PyResult<Self> {
        require(
            resolution.is_finite() && resolution > 0.0,
            "resolution must be positive",
        )?;
        let polygon: Vec<(f64, f64)> = points(&footprint)?.iter().map(|p| (p.x, p.y)).collect();
        require(
            polygon
                .iter()
                .all(|p| p.0.abs() / resolution < 1e3 && p.1.abs() / resolution < 1e3),
            "the footprint must be finite and within 1000 cells",
        )?;
        let headings: Vec<f64> = headings.as_array().iter().copied().collect();
        require(
            !headings.is_empty() && headings.iter().all(|h| h.is_finite()),
            "headings must be finite, at least one",
        )?;
        Ok(Self {
            views: views::Views::new(&polygon, &headings, resolution),
        })
    }

    /// Counts (N, K) of unseen cells for (N, 2) positions as column and row, nothing hidden: an upper bound.
    fn open_gains<'py>(
        &self,
        py: Python<'py>,
        unseen: PyReadonlyArray2<'py, u8>,
        positions: PyReadonlyArray2<'py, i32>,
    ) -> PyResult<Bound<'py, PyArray2<u32>>> {
        let (cells, columns, rows) = flat(&unseen);
        require(columns > 0 && rows > 0, "the grid has no cells")?;
        require(positions.shape()[1] == 2, "positions must have two columns")?;
        let positions: Vec<(i32, i32)> = positions
            .as_array()
            .rows()
            .into_iter()
            .map(|row| (row[0], row[1]))
            .collect();
        let grid = views::Grid {
            unseen: &cells,
            blocked: &[],
            columns,
            rows,
        };
        let gains = self.views.open_gains(&grid, &positions);
        if gains.is_empty() {
            return Ok(PyArray2::zeros(py, [0, self.views.count()], false));
        }
        reshaped(py, &gains, self.views.count())
    }

    /// Counts (N,) of unseen cells that no blocked cell hides, for (N, 3) views: column, row, heading's number.
    fn gains<'py>(
        &self,
        py: Python<'py>,
        unseen: PyReadonlyArray2<'py, u8>,
        blocked: PyReadonlyArray2<'py, u8>,
        views: PyReadonlyArray2<'py, i32>,
    ) -> PyResult<Bound<'py, PyArray1<u32>>> {
        let (unseen, columns, rows) = flat(&unseen);
        let (blocked, blocked_columns, blocked_rows) = flat(&blocked);
        require(
            (columns, rows) == (blocked_columns, blocked_rows) && columns > 0 && rows > 0,
            "unseen and blocked must have the same shape",
        )?;
        require(views.shape()[1] == 3, "views must have three columns")?;
        let views: Vec<(i32, i32, usize)> = views
            .as_array()
            .rows()
            .into_iter()
            .map(|row| (row[0], row[1], row[2].max(0) as usize))
            .collect();
        let grid = views::Grid {
            unseen: &unseen,
            blocked: &blocked,
            columns,
            rows,
        };
        Ok(PyArray1::from_vec(py, self.views.gains(&grid, &views)))
    }
}

fn reshaped<'py, T: numpy::Element + Copy>(
    py: Python<'py>,
    values: &[T],
    columns: usize,
) -> PyResult<Bound<'py, PyArray2<T>>> {
    let array = PyArray1::from_slice(py, values);
    numpy::PyArrayMethods::reshape(&array, [values.len() / columns, columns])
}

#[pymodule]
fn rover_native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<NativeField>()?;
    module.add_function(wrap_pyfunction!(clearance_map, module)?)?;
    module.add_function(wrap_pyfunction!(distance_field, module)?)?;
    module.add_class::<Views>()
}
