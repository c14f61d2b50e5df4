//! Who may drive, and what ends it: one table of state and event.
//!
//! The table is the whole truth. Whether an event may be raised at all (a refused arming, say) is decided before;
//! what an action does to motors and queue is decided by the caller. Nothing else changes the state.

use rover_protocol::messages::{state_cause, state_state};

/// `Stopping` of the wire is two states here, as only one of them may end without a latch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum State {
    #[default]
    Boot,
    /// Motors off, nothing wrong.
    Disarmed,
    /// Motors hold the rover, waiting for a run.
    Armed,
    Moving,
    /// Jerk-limited stop because of Disarm.
    Retiring,
    /// Jerk-limited stop for any other cause.
    Stopping,
    /// Motors off until an explicit re-arm.
    Latched,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    BootDone,
    /// A new token, and nothing speaks against arming.
    Arm,
    Disarm,
    StopCommand,
    EmergencyCommand,
    EmergencyInput,
    DeadMan,
    SonarGuard,
    /// The bumper has touched something, see [`crate::bumper`].
    Bumper,
    /// A sensor that driving needs is lost, see [`crate::sensor_loss`].
    SensorLost,
    LowBattery,
    Stall,
    EncoderFault,
    Underrun,
    Internal,
    /// Nothing was injected for too long in test mode.
    InjectorSilent,
    RunStarted,
    RunEnded,
    /// The jerk-limited stop is over and the wheels stand.
    Stopped,
}

/// What the caller does when a transition is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    Nothing,
    /// Motors off this tick, motion dropped.
    Cut,
    /// Begin the jerk-limited stop, drop the queue.
    Brake,
    /// Motors on, holding the rover where it stands.
    PowerOn,
}

/// A transition, or none: the event means nothing in that state.
type Cell = Option<(State, Action)>;

const STATES: [State; 7] = [
    State::Boot,
    State::Disarmed,
    State::Armed,
    State::Moving,
    State::Retiring,
    State::Stopping,
    State::Latched,
];

const NONE: Cell = None;
const CUT: Cell = Some((State::Latched, Action::Cut));
const LATCH: Cell = Some((State::Latched, Action::Nothing));
const BRAKE: Cell = Some((State::Stopping, Action::Brake));
const TAKE_OVER: Cell = Some((State::Stopping, Action::Nothing));
const RETIRE: Cell = Some((State::Retiring, Action::Brake));
const ARM: Cell = Some((State::Armed, Action::PowerOn));
const READY: Cell = Some((State::Disarmed, Action::Nothing));
const OFF: Cell = Some((State::Disarmed, Action::Cut));
const MOVE: Cell = Some((State::Moving, Action::Nothing));
const HOLD: Cell = Some((State::Armed, Action::Nothing));

#[rustfmt::skip]
const TABLE: [(Event, [Cell; 7]); 19] = [
    //                         Boot   Disarmed  Armed   Moving  Retiring   Stopping  Latched
    (Event::BootDone,         [READY, NONE,     NONE,   NONE,   NONE,      NONE,     NONE]),
    (Event::Arm,              [NONE,  ARM,      NONE,   NONE,   NONE,      NONE,     ARM ]),
    (Event::Disarm,           [NONE,  NONE,     RETIRE, RETIRE, NONE,      NONE,     NONE]),
    (Event::StopCommand,      [NONE,  LATCH,    BRAKE,  BRAKE,  TAKE_OVER, NONE,     NONE]),
    (Event::EmergencyCommand, [CUT,   CUT,      CUT,    CUT,    CUT,       CUT,      NONE]),
    (Event::EmergencyInput,   [CUT,   CUT,      CUT,    CUT,    CUT,       CUT,      NONE]),
    (Event::DeadMan,          [NONE,  NONE,     BRAKE,  BRAKE,  NONE,      NONE,     NONE]),
    (Event::SonarGuard,       [NONE,  NONE,     NONE,   BRAKE,  NONE,      NONE,     NONE]),
    (Event::Bumper,           [NONE,  NONE,     CUT,    CUT,    CUT,       CUT,      NONE]),
    (Event::SensorLost,       [NONE,  NONE,     NONE,   RETIRE, NONE,      NONE,     NONE]),
    (Event::LowBattery,       [NONE,  NONE,     BRAKE,  BRAKE,  NONE,      NONE,     NONE]),
    (Event::Stall,            [NONE,  NONE,     CUT,    CUT,    CUT,       CUT,      NONE]),
    (Event::EncoderFault,     [NONE,  NONE,     CUT,    CUT,    CUT,       CUT,      NONE]),
    (Event::Underrun,         [NONE,  NONE,     NONE,   BRAKE,  NONE,      NONE,     NONE]),
    (Event::Internal,         [NONE,  NONE,     CUT,    CUT,    CUT,       CUT,      NONE]),
    (Event::InjectorSilent,   [NONE,  CUT,      CUT,    CUT,    CUT,       CUT,      NONE]),
    (Event::RunStarted,       [NONE,  NONE,     MOVE,   NONE,   NONE,      NONE,     NONE]),
    (Event::RunEnded,         [NONE,  NONE,     NONE,   HOLD,   NONE,      NONE,     NONE]),
    (Event::Stopped,          [NONE,  NONE,     NONE,   NONE,   OFF,       CUT,      NONE]),
];

/// The table's answer; None when the event means nothing in this state.
pub fn transition(state: State, event: Event) -> Cell {
    let (_, row) = TABLE.iter().find(|(candidate, _)| *candidate == event)?;
    let column = STATES.iter().position(|candidate| *candidate == state)?;
    row.get(column).copied().flatten()
}

/// Why an event stops the rover, None if it does not.
fn cause_of(event: Event) -> Option<u8> {
    Some(match event {
        Event::StopCommand => state_cause::STOP_COMMAND,
        Event::EmergencyCommand => state_cause::EMERGENCY_COMMAND,
        Event::EmergencyInput => state_cause::EMERGENCY_INPUT,
        Event::DeadMan => state_cause::DEAD_MAN,
        Event::SonarGuard => state_cause::SONAR_GUARD,
        Event::Bumper => state_cause::BUMPER,
        Event::SensorLost => state_cause::SENSOR_LOST,
        Event::LowBattery => state_cause::LOW_BATTERY,
        Event::Stall => state_cause::STALL,
        Event::EncoderFault => state_cause::ENCODER_FAULT,
        Event::Underrun => state_cause::UNDERRUN,
        Event::Disarm => state_cause::DISARM,
        Event::Internal => state_cause::INTERNAL,
        Event::InjectorSilent => state_cause::INJECTOR_SILENT,
        Event::BootDone | Event::Arm | Event::RunStarted | Event::RunEnded | Event::Stopped => {
            return None
        }
    })
}

/// The state, and why it is what it is.
#[derive(Clone, Debug, Default)]
pub struct Supervisor {
    state: State,
    cause: u8,
    detail: u8,
}

impl Supervisor {
    /// Take an event; `detail` is the reason byte of a command or the number of a sensor or wheel.
    pub fn handle(&mut self, event: Event, detail: u8) -> Action {
        let Some((state, action)) = transition(self.state, event) else {
            return Action::Nothing;
        };
        self.state = state;
        if event == Event::Arm {
            (self.cause, self.detail) = (state_cause::NONE, 0);
        } else if let Some(cause) = cause_of(event) {
            (self.cause, self.detail) = (cause, detail);
        }
        action
    }

    pub fn state(&self) -> State {
        self.state
    }

    /// Cause and detail, as State carries them.
    pub fn cause(&self) -> (u8, u8) {
        (self.cause, self.detail)
    }

    /// Motion is accepted and the dead-man watches.
    pub fn accepts_motion(&self) -> bool {
        matches!(self.state, State::Armed | State::Moving)
    }

    /// A jerk-limited stop is under way.
    pub fn is_stopping(&self) -> bool {
        matches!(self.state, State::Retiring | State::Stopping)
    }

    /// The motors are driven.
    pub fn is_powered(&self) -> bool {
        self.accepts_motion() || self.is_stopping()
    }

    /// The state's number on the wire.
    pub fn state_number(&self) -> u8 {
        match self.state {
            State::Boot => state_state::BOOT,
            State::Disarmed => state_state::DISARMED,
            State::Armed => state_state::ARMED,
            State::Moving => state_state::MOVING,
            State::Retiring | State::Stopping => state_state::STOPPING,
            State::Latched => state_state::LATCHED,
        }
    }
}

#[cfg(test)]
#[path = "supervisor_tests.rs"]
mod tests;
