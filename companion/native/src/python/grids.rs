//! Python's questions to grids: clearance, travel distance, unseen cells in view.

use numpy::{PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;

use crate::geometry::Point;
use crate::lattice::travel_distance;
use crate::map::grid::Grid;
use crate::python::arrays::{flat, points, require, reshaped};
use crate::viewpoint::gain;
use crate::viewpoint::grid::Grid as ViewGrid;

/// Metres from the centre of each cell to the nearest blocked cell's square; 1e9 when nothing is blocked.
#[pyfunction]
pub fn clearance_map<'py>(
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
    reshaped(py, grid.clearance_map(), columns)
}

/// Travel distance in metres over free cells from `start` = (column, row); infinite where there is no way.
#[pyfunction]
pub fn distance_field<'py>(
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
    let distances = travel_distance::distances(&cells, columns, rows, index, resolution);
    reshaped(py, &distances, columns)
}

/// How many unseen cells a camera would see: its footprint at a set of headings, prepared once.
#[pyclass(frozen)]
pub struct Views {
    views: gain::Views,
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
            views: gain::Views::new(&polygon, &headings, resolution),
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
        let grid = ViewGrid {
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
        let grid = ViewGrid {
            unseen: &unseen,
            blocked: &blocked,
            columns,
            rows,
        };
        Ok(PyArray1::from_vec(py, self.views.gains(&grid, &views)))
    }
}
