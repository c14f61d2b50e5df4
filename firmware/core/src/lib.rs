//! What the rover's microcontroller does, without the microcontroller.
//!
//! [`Core`] takes bytes from the link and one set of [`Inputs`] a millisecond, and gives [`Outputs`] and bytes back.
//! Time comes in as an argument; there is no clock, no pin and no interrupt here, so that the same code runs on the
//! board, in virtual time on a desktop and in tests. No heap, no floating point, no unsafe code, and no input that
//! makes it panic.

#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]
#![cfg_attr(
    not(test),
    deny(
        clippy::indexing_slicing,
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::unreachable
    )
)]

mod axis;
mod battery;
mod bumper;
mod clock;
mod commands;
mod controller;
pub mod crash;
mod crash_service;
mod drive_check;
mod faults;
mod fixed_point;
mod guard;
mod indicator;
mod inertial;
mod injection;
mod io;
mod link;
mod log;
mod motion;
mod odometry;
mod parameter_service;
pub mod parameter_table;
pub mod parameters;
mod reports;
mod segment_inbox;
mod senses;
mod sensor_loss;
mod settings;
mod sonar;
mod stop;
pub mod storage;
mod supervisor;
mod telemetry;
mod test_mode;
mod trigonometry;
mod velocity_observer;
mod wheels;
mod wiring;

pub use controller::Core;
pub use io::{board, reset_cause, Identity, InertialSample, Inputs, Outputs, Reboot, SonarEcho};
pub use link::OutgoingFrame;
