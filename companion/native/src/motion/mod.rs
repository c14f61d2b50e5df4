//! Driving along bends: the fastest speed from node to node, and the constant-jerk segments that realise it.

pub mod banded;
pub mod bend;
pub mod fastest;
pub mod limits;
