//! What the core gets from its board every millisecond, and what it gives back.

pub use crate::inertial::InertialSample;
pub use crate::sonar::SonarEcho;
pub use rover_protocol::messages::{
    hello_build_reset_cause as reset_cause, hello_reply_board as board,
};

/// Who this firmware is, as the handshake tells it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Identity {
    /// One of [`board`].
    pub board: u8,
    /// First 32 bits of the commit.
    pub git_hash: u32,
    /// One of [`reset_cause`].
    pub reset_cause: u8,
}

/// One tick's measurements.
#[derive(Clone, Copy, Debug, Default)]
pub struct Inputs {
    /// Time since boot; never goes back. The tick's nominal time, if the board has one.
    pub now_us: u64,
    /// When the tick really began: later than `now_us` on a board that was kept from it.
    pub began_us: u64,
    /// Quadrature counts, x4, forward positive, wrapping.
    pub encoder_left: i32,
    pub encoder_right: i32,
    pub battery_mv: u16,
    /// True while the emergency-stop input is active.
    pub emergency_stop: bool,
    /// True while a switch of the bumper is pressed.
    pub bumper: bool,
    /// A ranging that has ended since the last tick.
    pub sonar: Option<SonarEcho>,
    /// What the inertial sensor has measured since the last tick, if there is one.
    pub inertial: Option<InertialSample>,
}

/// What the board is to do until the next tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Outputs {
    /// Q15: 32767 is full duty forward.
    pub duty_left: i16,
    pub duty_right: i16,
    /// False: the bridges are off and the wheels coast.
    pub powered: bool,
    /// Sensor to ping now: 0 left, 1 centre, 2 right.
    pub sonar_trigger: Option<u8>,
    pub led: bool,
    pub buzzer: bool,
}

/// A restart that the companion asked for and the board has to carry out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reboot {
    Restart,
    Bootloader,
}
