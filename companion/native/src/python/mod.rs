//! What Python calls: arrays in, arrays out, every value checked here.

mod arrays;
mod field;
mod grids;
mod motion;
mod planner;
mod request;
mod segments;

use pyo3::prelude::*;

#[pymodule]
fn rover_native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<field::NativeField>()?;
    module.add_class::<planner::NativePlanner>()?;
    module.add_function(wrap_pyfunction!(grids::clearance_map, module)?)?;
    module.add_function(wrap_pyfunction!(grids::distance_field, module)?)?;
    module.add_function(wrap_pyfunction!(motion::bend_speeds, module)?)?;
    module.add_function(wrap_pyfunction!(motion::averaged, module)?)?;
    module.add_function(wrap_pyfunction!(motion::averaged_bending, module)?)?;
    module.add_function(wrap_pyfunction!(motion::heading_splines, module)?)?;
    module.add_function(wrap_pyfunction!(motion::curve_points, module)?)?;
    module.add_class::<segments::SegmentRow>()?;
    module.add_class::<segments::RowMark>()?;
    module.add_function(wrap_pyfunction!(segments::segments_way, module)?)?;
    module.add_function(wrap_pyfunction!(segments::way_beside, module)?)?;
    module.add_class::<grids::Views>()
}
