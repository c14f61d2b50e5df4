//! Bends, for Python's trajectories: averages, splines, speeds.

use numpy::{PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;

use crate::motion::average;
use crate::motion::curves;
use crate::motion::fastest::{fastest, Former};
use crate::motion::limits::{Axis, Limits};
use crate::motion::rows::Bend;
use crate::python::arrays::{pairs, require, reshaped};

pub fn limits_of(travel: (f64, f64), heading: (f64, f64)) -> PyResult<Limits> {
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

type FormerSpeeds<'py> = (
    PyReadonlyArray1<'py, f64>,
    PyReadonlyArray1<'py, f64>,
    PyReadonlyArray1<'py, f64>,
);
type Speeds<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>);

/// (N + 1,) speeds and accelerations at the nodes of N curves; SI. `thirds`: (N, 2) second derivative of curvature at the
/// beginning and at the end of each curve; `travel`, `heading`: most acceleration and jerk.
/// `former`: most speed, share and speed at the nodes of the same curves, to begin with.
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
    former: Option<FormerSpeeds<'py>>,
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
    let former = match &former {
        None => None,
        Some((most, share, speed)) => {
            let (most, share, speed) = (most.as_slice()?, share.as_slice()?, speed.as_slice()?);
            let same = [most, share, speed].iter().all(|each| each.len() == nodes);
            require(same, "values at every node")?;
            Some(Former { most, share, speed })
        }
    };
    let (speed, acceleration) = fastest(&bend, &limits, former.as_ref());
    Ok((
        PyArray1::from_vec(py, speed),
        PyArray1::from_vec(py, acceleration),
    ))
}

type Axes<'py> = (
    PyReadonlyArray1<'py, f64>,
    PyReadonlyArray2<'py, f64>,
    PyReadonlyArray1<'py, i64>,
    PyReadonlyArray1<'py, f64>,
    PyReadonlyArray2<'py, f64>,
);

type Places<'py> = (
    PyReadonlyArray1<'py, f64>,
    PyReadonlyArray1<'py, f64>,
    PyReadonlyArray1<'py, f64>,
);

/// `each` of the average at all places: their arc length, window, and its slope.
fn at_places<const N: usize>(
    axis: &Axes<'_>,
    places: &Places<'_>,
    each: impl Fn(&average::Averaged) -> [f64; N],
) -> PyResult<Vec<[f64; N]>> {
    let (way, points, legs, at, change) = axis;
    let (points, change) = (pairs(points)?, pairs(change)?);
    let axis = average::Axis {
        u: way.as_slice()?,
        points: &points,
        legs: legs.as_slice()?,
        at: at.as_slice()?,
        change: &change,
    };
    let (u, window, slope) = (
        places.0.as_slice()?,
        places.1.as_slice()?,
        places.2.as_slice()?,
    );
    let count = axis.u.len();
    let fits = |leg: &i64| *leg >= 0 && (*leg as usize) + 1 < count;
    require(
        points.len() == count && axis.legs.len() == count && axis.legs.iter().all(fits),
        "a leg that leads on for each point",
    )?;
    require(change.len() == axis.at.len(), "a change for each vertex")?;
    require(
        window.len() == u.len() && slope.len() == u.len() && window.iter().all(|w| *w > 0.0),
        "a window for each place",
    )?;
    let places = u.iter().zip(window).zip(slope);
    let found = places.map(|((u, w), slope)| each(&average::averaged(&axis, *u, *w, *slope)));
    Ok(found.collect())
}

/// (K, 4): the average of polylines and its slope over the axis, x and y each, at K places; see average.py. `axis`: arc
/// lengths (N,), points (N, 2), legs (N,), vertices (M,), changes of direction (M, 2); `places`: arc length, window and
/// its slope, (K,) each.
#[pyfunction]
pub fn averaged<'py>(
    py: Python<'py>,
    axis: Axes<'py>,
    places: Places<'py>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let found = at_places(&axis, &places, |[value, first, ..]| {
        [value[0], value[1], first[0], first[1]]
    })?;
    reshaped(py, found.as_flattened(), 4)
}

/// (4, K): how far the average is from the polylines, and the magnitudes of its curvature and of the first two
/// derivatives of that over arc length.
#[pyfunction]
pub fn averaged_bending<'py>(
    py: Python<'py>,
    axis: Axes<'py>,
    places: Places<'py>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let found = at_places(&axis, &places, average::bending)?;
    let column = |number: usize| found.iter().map(move |row| row[number]);
    let found: Vec<f64> = (0..4).flat_map(column).collect();
    reshaped(py, &found, found.len() / 4)
}

/// (N, 4): curvature at both ends of N curves, and its slope at both, of the cubic spline of heading over arc length of
/// each run. `ends`: the number of curves up to the end of each run.
#[pyfunction]
pub fn heading_splines<'py>(
    py: Python<'py>,
    length: PyReadonlyArray1<'py, f64>,
    angle: PyReadonlyArray1<'py, f64>,
    ends: PyReadonlyArray1<'py, i64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let (length, angle, ends) = (length.as_slice()?, angle.as_slice()?, ends.as_slice()?);
    let ascending = ends.windows(2).all(|pair| pair[0] < pair[1]);
    require(
        ends.first().is_none_or(|end| *end > 0)
            && ascending
            && ends.last().map_or(0, |end| *end as usize) == length.len()
            && angle.len() == length.len(),
        "runs of curves, with an angle for each curve",
    )?;
    let mut spline = curves::Spline::default();
    let mut begin = 0;
    for end in ends.iter().map(|end| *end as usize) {
        curves::add_run(&mut spline, &length[begin..end], &angle[begin..end]);
        begin = end;
    }
    let each = |i: usize| [spline.k0[i], spline.k1[i], spline.r0[i], spline.r1[i]];
    let found: Vec<f64> = (0..length.len()).flat_map(each).collect();
    reshaped(py, &found, 4)
}

/// ((chords + 1) N, 2): the ends of equal parts of N curves. `curves` (N, 9): x, y, heading, length, curvature and its
/// slope at the beginning, third derivative of heading on three equal parts.
#[pyfunction]
pub fn curve_points<'py>(
    py: Python<'py>,
    curves: PyReadonlyArray2<'py, f64>,
    chords: usize,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    require(curves.shape()[1] == 9, "nine columns for each curve")?;
    require(chords > 0, "at least one chord")?;
    let mut found = Vec::with_capacity(2 * (chords + 1) * curves.shape()[0]);
    for row in curves.as_array().rows() {
        let curve = curves::Curve {
            at: [row[0], row[1]],
            heading: row[2],
            length: row[3],
            curvature: row[4],
            slope: row[5],
            thirds: [row[6], row[7], row[8]],
        };
        found.extend(curve.points(chords).flatten());
    }
    reshaped(py, &found, 2)
}
