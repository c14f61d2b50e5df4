//! Graph search over the map: what a sampling planner cannot do by itself. A lattice proves goals unreachable, and finds
//! paths through passages into which random samples seldom fall.

pub mod a_star;
pub mod bidirectional;
pub mod cache;
pub mod feasibility;
pub mod frontier;
pub mod graph;
pub mod labels;
pub mod queue;
pub mod travel_distance;
