//! Python's `NativePlanner`: plans anew whenever the map changes, and keeps what is still valid.

use numpy::PyReadonlyArray2;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::path::simplify::{self, Simplification};
use crate::planner::plan;
use crate::python::field::{answer, on, Map, NativeField};
use crate::python::request::Settings;
use crate::replan::state::ReplanState;

/// One tree towards all goals that outlives the map it was grown on.
#[pyclass]
pub struct NativePlanner {
    state: ReplanState,
}

#[pymethods]
impl NativePlanner {
    #[new]
    fn new(seed: u64) -> Self {
        Self {
            state: ReplanState::new(seed),
        }
    }

    /// Builds a roadmap of `field` for the plans to come; returns its numbers of nodes and edges.
    fn prepare(&mut self, py: Python<'_>, field: &NativeField, radius: f64) -> (usize, usize) {
        let settings = Simplification {
            radius,
            corner_cost: 0.0,
            least_move: simplify::LEAST_MOVE,
            deadline: None,
        };
        let (map, state) = (&field.map, &mut self.state);
        py.detach(|| on!(map, field => state.prepare(field, settings)))
    }

    /// As `NativeField.plan` with "multi-goal"; the answer also says how many nodes were kept, pruned and rewired.
    fn plan<'py>(
        &mut self,
        py: Python<'py>,
        field: &NativeField,
        start: (f64, f64),
        goals: PyReadonlyArray2<'py, f64>,
        settings: Settings,
    ) -> PyResult<Bound<'py, PyDict>> {
        let request = settings.request(start, &goals, "multi-goal", 0)?;
        let state = &mut self.state;
        let outcome = py.detach(|| {
            field.with_lattices(
                |lattices| on!(&field.map, field => plan::replan(field, &request, lattices, state)),
            )
        });
        let repair = self.state.repair;
        let result = answer(py, outcome)?;
        result.set_item("kept", repair.kept)?;
        result.set_item("pruned", repair.pruned)?;
        result.set_item("rewired", repair.rewired)?;
        Ok(result)
    }
}
