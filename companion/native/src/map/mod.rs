//! Maps: circles in a rectangle, or grids of blocked cells, both behind the trait `Field`.

pub mod capsule;
mod circle_buckets;
pub mod circles;
pub mod clearance_tiles;
pub mod distance_transform;
pub mod field;
pub mod grid;
mod grid_checks;
mod square;
pub mod uncached;
