//! What a camera on the robot would see.

pub mod footprint;
pub mod gain;
pub mod grid;
