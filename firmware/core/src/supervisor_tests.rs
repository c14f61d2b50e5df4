//! The whole table, cell by cell and by what must hold for all of it.

use super::*;

const EVENTS: [Event; 19] = [
    Event::BootDone,
    Event::Arm,
    Event::Disarm,
    Event::StopCommand,
    Event::EmergencyCommand,
    Event::EmergencyInput,
    Event::DeadMan,
    Event::SonarGuard,
    Event::Bumper,
    Event::SensorLost,
    Event::LowBattery,
    Event::Stall,
    Event::EncoderFault,
    Event::Underrun,
    Event::Internal,
    Event::InjectorSilent,
    Event::RunStarted,
    Event::RunEnded,
    Event::Stopped,
];

fn every_pair() -> impl Iterator<Item = (State, Event, Cell)> {
    STATES.into_iter().flat_map(|state| {
        EVENTS
            .into_iter()
            .map(move |event| (state, event, transition(state, event)))
    })
}

#[test]
fn every_event_has_exactly_one_row() {
    for event in EVENTS {
        assert_eq!(TABLE.iter().filter(|(e, _)| *e == event).count(), 1);
    }
    assert_eq!(TABLE.len(), EVENTS.len());
}

/// A second, independent account of what is wanted: the digits are the next state, `.` no change.
/// b boot, d disarmed, a armed, m moving, r retiring, s stopping, l latched.
#[test]
fn every_cell_is_as_specified() {
    let expected = [
        (Event::BootDone, "d......"),
        (Event::Arm, ".a....a"),
        (Event::Disarm, "..rr..."),
        (Event::StopCommand, ".lsss.."),
        (Event::EmergencyCommand, "llllll."),
        (Event::EmergencyInput, "llllll."),
        (Event::DeadMan, "..ss..."),
        (Event::SonarGuard, "...s..."),
        (Event::Bumper, "..llll."),
        (Event::SensorLost, "...r..."),
        (Event::LowBattery, "..ss..."),
        (Event::Stall, "..llll."),
        (Event::EncoderFault, "..llll."),
        (Event::Underrun, "...s..."),
        (Event::Internal, "..llll."),
        (Event::InjectorSilent, ".lllll."),
        (Event::RunStarted, "..m...."),
        (Event::RunEnded, "...a..."),
        (Event::Stopped, "....dl."),
    ];
    for (event, row) in expected {
        for (state, letter) in STATES.into_iter().zip(row.chars()) {
            let next = transition(state, event).map(|(next, _)| match next {
                State::Boot => 'b',
                State::Disarmed => 'd',
                State::Armed => 'a',
                State::Moving => 'm',
                State::Retiring => 'r',
                State::Stopping => 's',
                State::Latched => 'l',
            });
            assert_eq!(next.unwrap_or('.'), letter, "{state:?} {event:?}");
        }
    }
}

#[test]
fn only_arming_leaves_the_latch_and_only_arming_switches_the_motors_on() {
    for (state, event, cell) in every_pair() {
        let Some((next, action)) = cell else { continue };
        if state == State::Latched {
            assert_eq!(event, Event::Arm);
        }
        if action == Action::PowerOn || (next == State::Armed && state != State::Moving) {
            assert_eq!(event, Event::Arm);
        }
    }
}

#[test]
fn an_emergency_cuts_the_motors_from_every_state_that_drives_them() {
    for event in [Event::EmergencyCommand, Event::EmergencyInput] {
        for state in STATES {
            let cell = transition(state, event);
            let expected = (state != State::Latched).then_some((State::Latched, Action::Cut));
            assert_eq!(cell, expected);
        }
    }
}

#[test]
fn motors_are_off_by_a_cut_whenever_a_driving_state_is_left_for_one_that_does_not_drive() {
    let drives = |state| {
        let supervisor = Supervisor {
            state,
            ..Supervisor::default()
        };
        supervisor.is_powered()
    };
    for (state, event, cell) in every_pair() {
        let Some((next, action)) = cell else { continue };
        if drives(state) && !drives(next) {
            assert_eq!(action, Action::Cut, "{state:?} {event:?}");
        }
    }
}

#[test]
fn the_first_cause_stays_until_the_next_arming_unless_an_emergency_overtakes_the_stop() {
    let mut supervisor = Supervisor::default();
    supervisor.handle(Event::BootDone, 0);
    supervisor.handle(Event::Arm, 0);
    supervisor.handle(Event::RunStarted, 0);
    assert_eq!(supervisor.handle(Event::SonarGuard, 1), Action::Brake);
    supervisor.handle(Event::StopCommand, 9);
    assert_eq!(supervisor.cause(), (state_cause::SONAR_GUARD, 1));
    supervisor.handle(Event::EmergencyCommand, 7);
    assert_eq!(supervisor.cause(), (state_cause::EMERGENCY_COMMAND, 7));
    supervisor.handle(Event::StopCommand, 3);
    supervisor.handle(Event::EmergencyInput, 0);
    assert_eq!(supervisor.cause(), (state_cause::EMERGENCY_COMMAND, 7));
    supervisor.handle(Event::Arm, 0);
    assert_eq!(supervisor.cause(), (state_cause::NONE, 0));
}
