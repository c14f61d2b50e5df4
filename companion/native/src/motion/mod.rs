//! Driving: smooth curves through dense points, the fastest speed from node to node, the constant-jerk segments that
//! realise it, and what these really do.

pub mod average;
pub mod banded;
pub mod bend;
pub mod curves;
pub mod driven;
pub mod fastest;
pub mod interior_point;
pub mod limits;
pub mod row;
pub mod rows;
