//! Python's `NativePlanner`: plans again and again, and keeps what still holds.

use numpy::PyReadonlyArray2;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::memory::Memory;
use crate::planner;
use crate::python_field::{answer, on, Map, NativeField};
use crate::python_request::Settings;
use crate::shorten::{self, Shortening};

/// One tree towards all goals that outlives the map it was grown on.
#[pyclass]
pub struct NativePlanner {
    memory: Memory,
}

#[pymethods]
impl NativePlanner {
    #[new]
    fn new(seed: u64) -> Self {
        Self {
            memory: Memory::new(seed),
        }
    }

    /// Surveys `field`'s ground for the plans to come; nodes and edges of what is kept of it.
    fn prepare(&mut self, py: Python<'_>, field: &NativeField, radius: f64) -> (usize, usize) {
        let settings = Shortening {
            radius,
            corner_cost: 0.0,
            least_move: shorten::LEAST_MOVE,
            deadline: None,
        };
        let (map, memory) = (&field.map, &mut self.memory);
        py.detach(|| on!(map, field => memory.prepare(field, settings)))
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
        let (map, memory) = (&field.map, &mut self.memory);
        let outcome = py.detach(|| on!(map, field => planner::plan_again(field, &request, memory)));
        let repair = self.memory.repair;
        let result = answer(py, outcome)?;
        result.set_item("kept", repair.kept)?;
        result.set_item("pruned", repair.pruned)?;
        result.set_item("rewired", repair.rewired)?;
        Ok(result)
    }
}
