//! Between numpy arrays and the planner's own types, with the checks that every door needs.

use numpy::{PyArray1, PyArray2, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::geometry::Point;

pub fn flat<'py, T: numpy::Element + Copy>(
    array: &PyReadonlyArray2<'py, T>,
) -> (Vec<T>, usize, usize) {
    let shape = array.shape();
    (
        match array.as_slice() {
            Ok(values) => values.to_vec(),
            Err(_) => array.as_array().iter().copied().collect(),
        },
        shape[1],
        shape[0],
    )
}

pub fn points(array: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<Point>> {
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

pub fn require(condition: bool, message: &str) -> PyResult<()> {
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
pub fn array_of<'py>(py: Python<'py>, path: &[Point]) -> PyResult<Bound<'py, PyArray2<f64>>> {
    if path.is_empty() {
        return Ok(PyArray2::zeros(py, [0, 2], false));
    }
    PyArray2::from_vec2(py, &rows_of(path))
        .map_err(|error| PyValueError::new_err(error.to_string()))
}

pub fn reshaped<'py, T: numpy::Element + Copy>(
    py: Python<'py>,
    values: &[T],
    columns: usize,
) -> PyResult<Bound<'py, PyArray2<T>>> {
    let array = PyArray1::from_slice(py, values);
    numpy::PyArrayMethods::reshape(&array, [values.len() / columns, columns])
}

/// (N, 2) as pairs.
pub fn pairs(array: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<[f64; 2]>> {
    require(array.shape()[1] == 2, "two columns")?;
    let rows = array.as_array();
    Ok(rows
        .rows()
        .into_iter()
        .map(|row| [row[0], row[1]])
        .collect())
}
