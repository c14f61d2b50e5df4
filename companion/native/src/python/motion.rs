//! Speeds and segments of bends, for Python's trajectories.

use numpy::{PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;

use crate::motion::bend::{drive, Curve, State};
use crate::motion::fastest::{fastest, Bend};
use crate::motion::limits::{Axis, Limits};
use crate::python::arrays::{require, reshaped};

fn limits_of(travel: (f64, f64), heading: (f64, f64)) -> PyResult<Limits> {
    let all = [travel.0, travel.1, heading.0, heading.1];
    require(
        all.iter().all(|each| each.is_finite() && *each > 0.0),
        "limits must be positive",
    )?;
    let axis = |(acceleration, jerk)| Axis { acceleration, jerk };
    Ok(Limits {
        travel: axis(travel),
        heading: axis(heading),
    })
}

type Speeds<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>);

/// (N + 1,) speeds and accelerations at the nodes of N curves; SI. `thirds`: (N, 2) second derivative of curvature at the
/// beginning and at the end of each curve; `travel`, `heading`: most acceleration and jerk.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
pub fn bend_speeds<'py>(
    py: Python<'py>,
    length: PyReadonlyArray1<'py, f64>,
    curvature: PyReadonlyArray1<'py, f64>,
    slope: PyReadonlyArray1<'py, f64>,
    thirds: PyReadonlyArray2<'py, f64>,
    most: PyReadonlyArray1<'py, f64>,
    share: PyReadonlyArray1<'py, f64>,
    travel: (f64, f64),
    heading: (f64, f64),
) -> PyResult<Speeds<'py>> {
    let limits = limits_of(travel, heading)?;
    let (length, curvature, slope) = (length.as_slice()?, curvature.as_slice()?, slope.as_slice()?);
    let (most, share) = (most.as_slice()?, share.as_slice()?);
    let nodes = length.len() + 1;
    require(
        nodes >= 3
            && [curvature, slope, most, share]
                .iter()
                .all(|each| each.len() == nodes),
        "a bend has at least two curves, and values at every node",
    )?;
    require(
        thirds.shape() == [nodes - 1, 2],
        "two derivatives for each curve",
    )?;
    require(length.iter().all(|h| *h > 0.0), "lengths must be positive")?;
    let thirds = thirds.as_array();
    let mut before = vec![0.0; nodes];
    let mut behind = vec![0.0; nodes];
    for (i, row) in thirds.rows().into_iter().enumerate() {
        behind[i] = row[0];
        before[i + 1] = row[1];
    }
    let bend = Bend {
        length,
        curvature,
        slope,
        before: &before,
        behind: &behind,
        most,
        share,
    };
    let (speed, acceleration) = fastest(&bend, &limits);
    Ok((
        PyArray1::from_vec(py, speed),
        PyArray1::from_vec(py, acceleration),
    ))
}

type Motion = (f64, f64, f64, f64, f64, f64, f64);
type Driven<'py> = (Bound<'py, PyArray2<i64>>, Motion);

/// (3 N, 3) durations in µs and jerks in millionths of the SI unit along N curves, and the state at their end.
///
/// `state`: x, y, heading, speed, acceleration, turn rate, turn acceleration; `curves` (N, 10): x, y, heading, length and
/// angle of each, speed, acceleration, curvature and its slope at its end, length of the piece behind it.
#[pyfunction]
pub fn drive_bend<'py>(
    py: Python<'py>,
    state: Motion,
    curves: PyReadonlyArray2<'py, f64>,
    travel: (f64, f64),
    heading: (f64, f64),
) -> PyResult<Driven<'py>> {
    let limits = limits_of(travel, heading)?;
    require(curves.shape()[1] == 10, "ten columns for each curve")?;
    let (x, y, direction, speed, acceleration, turn_rate, turn_acceleration) = state;
    let mut state = State {
        x,
        y,
        heading: direction,
        speed,
        acceleration,
        turn_rate,
        turn_acceleration,
    };
    let mut found = Vec::with_capacity(9 * curves.shape()[0]);
    for row in curves.as_array().rows() {
        let curve = Curve {
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
        };
        found.extend(drive(&mut state, &curve, &limits).iter().flatten());
    }
    let end = (
        state.x,
        state.y,
        state.heading,
        state.speed,
        state.acceleration,
        state.turn_rate,
        state.turn_acceleration,
    );
    Ok((reshaped(py, &found, 3)?, end))
}
