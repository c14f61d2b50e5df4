//! `rover_plant`: the simulated world of the rover as a Python module. Physics and sensors are plain Rust, stepped at
//! 1 kHz; the fast half of the emulated RP2040 is here, too.
//!
//! The unit tests are built without what needs an interpreter, which only the module has.

#![warn(missing_docs)]
#![cfg_attr(test, allow(dead_code))]

pub mod attitude;
pub mod battery;
pub mod bolometer;
pub mod bumper;
pub mod camera;
pub mod chip;
pub mod config;
pub mod drive;
pub mod faults;
pub mod hand;
pub mod inertial;
pub mod lens;
pub mod obstacle;
pub mod pose;
#[cfg(not(test))]
pub mod python;
pub mod random;
pub mod referee;
pub mod sitl;
pub mod slip_bursts;
pub mod sonar;
pub mod survey;
pub mod terrain;
pub mod tiles;
pub mod wire;
pub mod wiring;
mod world;
