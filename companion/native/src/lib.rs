//! Python's door to the planner's inner loops: arrays in, arrays out, every value checked here.

mod again;
mod arrays;
mod budget;
mod capsule;
mod circles;
mod closely;
mod connect;
mod detour;
mod dijkstra;
mod elastic;
mod escape;
mod field;
mod geometry;
mod grid;
mod ground;
mod hang;
mod lattice;
mod memory;
mod mend;
mod mended;
mod order;
mod planner;
mod python_field;
mod python_grids;
mod python_planner;
mod python_request;
mod random;
mod roadmap;
mod route;
mod rrt;
mod search;
mod shorten;
mod star;
mod tiles;
mod tour;
mod transform;
mod tree;
mod views;
mod wave;

use pyo3::prelude::*;

#[pymodule]
fn rover_native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<python_field::NativeField>()?;
    module.add_class::<python_planner::NativePlanner>()?;
    module.add_function(wrap_pyfunction!(python_grids::clearance_map, module)?)?;
    module.add_function(wrap_pyfunction!(python_grids::distance_field, module)?)?;
    module.add_class::<python_grids::Views>()
}
