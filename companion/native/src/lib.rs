//! The inner loops of the rover's planner and of its motion.
//!
//! A plan is a pure function of a map, a request and a seed. The folders, each of which uses only those before it:
//! `map` (collision checks and clearance), `lattice` and `tangent` (graph search), `tree` (sampling planners), `path`
//! (simplification, order of visit), `replan` (what survives when the map changes), `planner` (one plan from request to
//! outcome). `motion` finds speeds along bends and the segments that drive them. `viewpoint` counts what a camera would
//! see. `python` converts and checks values, and does nothing else.

#![warn(missing_docs)]

pub mod budget;
pub mod geometry;
pub mod lattice;
pub mod map;
pub mod motion;
pub mod path;
pub mod planner;
// Links against the interpreter that imports it, so that the unit tests do without.
#[cfg(not(test))]
mod python;
pub mod random;
pub mod replan;
pub mod tangent;
pub mod tree;
pub mod viewpoint;
