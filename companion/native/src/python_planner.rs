//! Python's `NativePlanner`: plans again and again, and keeps what still holds.

use numpy::PyReadonlyArray2;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::points;
use crate::geometry::Point;
use crate::memory::Memory;
use crate::planner::{self, Algorithm, Request};
use crate::python_field::{answer, check, on, Map, NativeField};

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

    /// As `NativeField.plan` with "multi-goal"; the answer also says how many nodes were kept, pruned and rewired.
    #[allow(clippy::too_many_arguments)]
    fn plan<'py>(
        &mut self,
        py: Python<'py>,
        field: &NativeField,
        start: (f64, f64),
        goals: PyReadonlyArray2<'py, f64>,
        radius: f64,
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
            algorithm: Algorithm::MultiGoal,
            radius,
            seed: 0,
            iterations,
            budget_ms,
            any_order,
            start_escape,
            corner_cost,
            step,
            bias,
        };
        check(&request)?;
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
