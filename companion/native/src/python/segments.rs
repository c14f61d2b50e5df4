//! Rows of segments in the making, and what they really do, for Python's trajectories.

use numpy::{PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;

use crate::motion::bend::{Curve, State};
use crate::motion::driven::{beside, shares, way, Legs, Segment};
use crate::motion::row::{Mark, Row};
use crate::python::arrays::{pairs, require, reshaped};
use crate::python::motion::limits_of;

/// Segments in the making: whole numbers, and the exact state and pose at their end. Metres, radians, seconds.
#[pyclass]
pub struct SegmentRow {
    row: Row,
}

/// A place in a row, to come back to.
#[pyclass(frozen)]
pub struct RowMark(Mark);

#[pymethods]
impl RowMark {
    /// How many segments come before.
    #[getter]
    fn segments(&self) -> usize {
        self.0.segments
    }
}

#[pymethods]
impl SegmentRow {
    #[new]
    fn new(x: f64, y: f64, heading: f64) -> Self {
        let state = State {
            x,
            y,
            heading,
            ..State::default()
        };
        Self {
            row: Row::new(state),
        }
    }

    /// x, y, heading, speed, acceleration, turn rate, turn acceleration at the end.
    #[getter]
    fn state(&self) -> (f64, f64, f64, f64, f64, f64, f64) {
        let at = &self.row.state;
        (
            at.x,
            at.y,
            at.heading,
            at.speed,
            at.acceleration,
            at.turn_rate,
            at.turn_acceleration,
        )
    }

    fn __len__(&self) -> usize {
        self.row.fields.len()
    }

    /// One segment: µs, and millionths of the SI unit.
    fn add(&mut self, duration_us: i64, jerk_travel: i64, jerk_heading: i64) {
        self.row.add([duration_us, jerk_travel, jerk_heading]);
    }

    /// Three segments for each of N curves. `curves` (N, 10): x, y, heading, length and angle of each, speed,
    /// acceleration, curvature and its slope at its end, length of the piece behind it.
    fn follow(
        &mut self,
        curves: PyReadonlyArray2<'_, f64>,
        travel: (f64, f64),
        heading: (f64, f64),
    ) -> PyResult<()> {
        let limits = limits_of(travel, heading)?;
        require(curves.shape()[1] == 10, "ten columns for each curve")?;
        let rows = curves.as_array();
        let curves = rows.rows().into_iter().map(|row| Curve {
            x: row[0],
            y: row[1],
            heading: row[2],
            length: row[3],
            angle: row[4],
            speed: row[5],
            acceleration: row[6],
            curvature: row[7],
            slope: row[8],
            ahead: row[9],
        });
        self.row.follow(curves, &limits);
        Ok(())
    }

    /// What was added last ends at rest; what comes next begins a run.
    fn rest(&mut self) {
        self.row.rest();
    }

    fn mark(&self) -> RowMark {
        RowMark(self.row.mark())
    }

    /// Forgets what was added after the mark.
    fn reset(&mut self, mark: &RowMark) {
        self.row.reset(&mark.0);
    }

    /// (N, 2) of the segments behind a mark: the largest share of what is allowed of a speed, and of an acceleration or
    /// jerk. `allowed`: speed, acceleration, jerk, turn rate, turn acceleration, turn jerk, lateral acceleration.
    fn shares<'py>(
        &self,
        py: Python<'py>,
        mark: &RowMark,
        allowed: [f64; 7],
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let at = &mark.0.state;
        let state = [
            [at.speed, at.acceleration],
            [at.turn_rate, at.turn_acceleration],
        ];
        let behind = self.row.fields.get(mark.0.segments..).unwrap_or_default();
        let segments = behind
            .iter()
            .map(|row| Segment::of([row[0], row[1], row[2], row[4]]));
        reshaped(py, shares(state, segments, allowed).as_flattened(), 2)
    }

    /// (N, 5) from segment number `first` on: duration in µs, jerks in millionths of the SI unit, 1 where a run begins, 1
    /// where it ends at rest.
    fn fields<'py>(&self, py: Python<'py>, first: usize) -> PyResult<Bound<'py, PyArray2<i64>>> {
        let found = self.row.fields.get(first..).unwrap_or_default();
        reshaped(py, found.as_flattened(), 5)
    }
}

fn segments_of(fields: &PyReadonlyArray2<'_, i64>) -> PyResult<Vec<Segment>> {
    require(fields.shape()[1] == 5, "five fields for each segment")?;
    let rows = fields.as_array();
    let each = |row: numpy::ndarray::ArrayView1<'_, i64>| [row[0], row[1], row[2], row[4]];
    Ok(rows
        .rows()
        .into_iter()
        .map(|row| Segment::of(each(row)))
        .collect())
}

type Way<'py> = (
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<i64>>,
    Bound<'py, PyArray1<f64>>,
    [f64; 7],
);

/// Where N segments (N, 5) lead from rest at a pose: poses (N + 1, 3) between them, points (M, 2) on the way, the
/// segment (M,) that each is in, by how much the way leaves the chords between the points (M - 1,), and the most of speed,
/// acceleration, jerk, turn rate, turn acceleration, turn jerk and lateral acceleration.
#[pyfunction]
pub fn segments_way<'py>(
    py: Python<'py>,
    fields: PyReadonlyArray2<'py, i64>,
    pose: (f64, f64, f64),
) -> PyResult<Way<'py>> {
    let found = way(&segments_of(&fields)?, [pose.0, pose.1, pose.2]);
    Ok((
        reshaped(py, found.poses.as_flattened(), 3)?,
        reshaped(py, found.points.as_flattened(), 2)?,
        PyArray1::from_vec(py, found.segments),
        PyArray1::from_vec(py, found.bulges),
        found.most,
    ))
}

/// (M - 1,) metres, no less than the distance from the way between M points to the legs that its piece runs along.
///
/// `way`: points (M, 2), segment of each (M,), bulges (M - 1,); `line`: points (L + 1, 2) of a polyline and errors (L,)
/// of its legs; `starts` (K,): first segment of each piece; `legs` (K, 2): its first leg and the one behind its last.
#[pyfunction]
pub fn way_beside<'py>(
    py: Python<'py>,
    way: WayPoints<'py>,
    line: (PyReadonlyArray2<'py, f64>, PyReadonlyArray1<'py, f64>),
    starts: PyReadonlyArray1<'py, i64>,
    legs: PyReadonlyArray2<'py, i64>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let (points, polyline) = (pairs(&way.0)?, pairs(&line.0)?);
    let (segments, bulges) = (way.1.as_slice()?, way.2.as_slice()?);
    require(legs.shape()[1] == 2, "two legs for each piece")?;
    let rows = legs.as_array();
    let range: Vec<[i64; 2]> = rows
        .rows()
        .into_iter()
        .map(|row| [row[0], row[1]])
        .collect();
    let legs = Legs {
        points: &polyline,
        error: line.1.as_slice()?,
        starts: starts.as_slice()?,
        range: &range,
    };
    let fits = |[low, high]: &[i64; 2]| *low >= 0 && *high as usize <= legs.error.len();
    require(
        segments.len() == points.len()
            && bulges.len() + 1 == points.len()
            && legs.error.len() + 1 == polyline.len()
            && range.len() == legs.starts.len()
            && !range.is_empty()
            && range.iter().all(fits),
        "way, line and legs that fit together",
    )?;
    Ok(PyArray1::from_vec(
        py,
        beside(&legs, &points, segments, bulges),
    ))
}

type WayPoints<'py> = (
    PyReadonlyArray2<'py, f64>,
    PyReadonlyArray1<'py, i64>,
    PyReadonlyArray1<'py, f64>,
);
