//! The conversation with the companion: handshake, motion over a bad line, clock, parameters, telemetry.

mod rig;

use rig::{cruise_pieces, Piece, Random, Rig};
use rover_core::InertialSample;
use rover_protocol::messages as m;
use rover_protocol::messages::{
    fault_code, parameter_value_status as parameter, state_state as state,
};
use rover_protocol::Message;

#[test]
fn hello_is_answered_with_version_board_and_session_and_the_next_index() {
    let mut rig = Rig::new();
    rig.run_ms(12);
    rig.frames.clear();
    rig.send(&m::Hello {
        schema_hash: m::SCHEMA_HASH,
        session: 0xbeef,
    });
    rig.tick();
    let reply: m::HelloReply = rig.last().unwrap();
    assert_eq!(reply.schema_hash, m::SCHEMA_HASH);
    let build: m::HelloBuild = rig.last().unwrap();
    assert_eq!((build.accepted, build.session), (1, 0xbeef));
    assert_eq!(rig.state().flags & 1, 1);
    assert!(rig.last::<m::MotionStatus>().is_some());
}

#[test]
fn another_schema_is_answered_and_refused_and_arming_with_it() {
    let mut rig = Rig::new();
    rig.run_ms(100);
    rig.send(&m::Hello {
        schema_hash: 1,
        session: 2,
    });
    rig.arm();
    rig.run_ms(3);
    assert_eq!(rig.last::<m::HelloBuild>().unwrap().accepted, 0);
    assert_eq!(rig.state().state, state::DISARMED);
    assert_ne!(rig.state().faults & 1 << fault_code::SCHEMA_MISMATCH, 0);
}

#[test]
fn a_stranger_with_another_schema_does_not_take_a_running_session_away() {
    let mut rig = Rig::armed();
    rig.send(&m::Hello {
        schema_hash: 1,
        session: 2,
    });
    rig.run_ms(3);
    assert_eq!(rig.state().state, state::ARMED);
    assert_eq!(rig.state().flags & 1, 1);
}

#[test]
fn a_run_is_driven_to_its_end_and_acknowledged_segment_by_segment() {
    let mut rig = Rig::armed();
    rig.send_run(&cruise_pieces(3_000_000, 0, 1_000_000), true);
    rig.run_ms(10);
    assert_eq!((rig.status().next_index, rig.status().queued), (7, 7));
    assert_eq!(rig.state().state, state::ARMED, "waits for its start");
    rig.run_until_state(state::MOVING);
    assert_eq!(rig.now_us / 1000, 152, "50 ms after it was sent at 102 ms");
    rig.run_until_state(state::ARMED);
    rig.run_ms(100);
    let reference: m::ReferenceDistance = rig.last().unwrap();
    // 0.25 m/s for the cruise and twice the ramp of 0.667 s.
    assert_eq!(reference.travel, 41_666);
    assert_eq!(reference.heading, 0);
    assert_eq!((rig.status().queued, rig.status().executing), (0, 6));
    assert_eq!(rig.status().rejected, 0);
}

#[test]
fn a_line_that_loses_repeats_and_reorders_frames_changes_nothing_in_the_motion() {
    let expected = {
        let mut rig = Rig::armed();
        rig.send_run(&cruise_pieces(2_000_000, 5_000_000, 700_000), true);
        rig.run_ms(4_000);
        rig.last::<m::ReferenceDistance>().unwrap()
    };
    for seed in 0..20 {
        let mut random = Random(seed);
        let mut rig = Rig::armed();
        let pieces = cruise_pieces(2_000_000, 5_000_000, 700_000);
        let start_us = rig.now_us + 200_000;
        while rig.status().next_index < 7 {
            assert!(rig.now_us < start_us, "within the time that is left");
            let next = rig.status().next_index;
            for _ in 0..6 {
                // Any of the window, in any order, halves apart, one in five lost, many twice.
                let index = (u64::from(next) + random.below(4)).saturating_sub(1).min(6) as u16;
                offer_one(&mut rig, &mut random, &pieces, index, start_us);
            }
            rig.tick();
        }
        rig.run_ms(4_000);
        assert_eq!(
            rig.last::<m::ReferenceDistance>().unwrap(),
            expected,
            "seed {seed}"
        );
        assert_eq!(rig.state().state, state::ARMED);
    }
}

/// One of the three messages of a segment, or none at all.
fn offer_one(rig: &mut Rig, random: &mut Random, pieces: &[Piece], index: u16, start_us: u64) {
    let (duration, jerk_travel, jerk_heading) = pieces[usize::from(index)];
    let flags = u8::from(index == 0) | u8::from(usize::from(index) + 1 == pieces.len()) << 1;
    match random.below(5) {
        0 | 1 => rig.send(&m::SegmentTravel {
            index,
            duration,
            jerk_travel,
        }),
        2 => rig.send_start(0, start_us),
        3 => rig.send(&m::SegmentHeading {
            index,
            jerk_heading,
            flags,
        }),
        _ => {}
    }
}

#[test]
fn stale_segments_after_a_stop_are_known_as_old_and_a_run_begins_behind_them() {
    let mut rig = Rig::armed();
    rig.send_run(&cruise_pieces(3_000_000, 0, 5_000_000), true);
    rig.run_ms(1_000);
    rig.send(&m::Stop { reason: 0 });
    rig.run_until_state(state::LATCHED);
    let next = rig.status().next_index;
    rig.send_halves(next, (100_000, 0, 0), 0);
    rig.tick();
    assert_eq!(rig.status().rejected, 2, "not armed: each half");
    rig.arm();
    rig.tick();
    rig.send_halves(next, (100_000, 0, 0), 0);
    rig.tick();
    let skipped = next + 256;
    assert_eq!(
        (rig.status().next_index, rig.status().rejected),
        (skipped, 2)
    );
    let next = skipped;
    rig.next_index = next;
    rig.send_run(&cruise_pieces(3_000_000, 0, 100_000), true);
    rig.run_ms(100);
    assert_eq!(rig.status().next_index, next + 7);
    assert_eq!(rig.state().state, state::MOVING);
}

#[test]
fn a_start_in_the_past_or_too_far_ahead_is_refused() {
    for offset_us in [-1_000_i64, 10_001_000] {
        let mut rig = Rig::armed();
        rig.send_start(0, rig.now_us.wrapping_add_signed(offset_us));
        rig.send_halves(0, (100_000, 0, 0), 1);
        rig.tick();
        assert_eq!((rig.status().next_index, rig.status().rejected), (0, 1));
        assert_eq!(
            rig.last::<m::Fault>().unwrap().code,
            fault_code::SEGMENT_REJECTED
        );
    }
}

#[test]
fn a_full_queue_keeps_the_next_segment_until_there_is_room() {
    let mut rig = Rig::armed();
    rig.send_start(0, rig.now_us + 20_000);
    for index in 0..70 {
        rig.send_halves(index, (5_000, 0, 0), u8::from(index == 0));
    }
    rig.tick();
    assert_eq!((rig.status().next_index, rig.status().free_slots), (64, 0));
    rig.run_ms(100);
    assert!(rig.status().next_index >= 70, "{:?}", rig.status());
    assert_eq!(rig.status().rejected, 0);
}

#[test]
fn the_clock_is_told_with_the_moment_of_arrival() {
    let mut rig = Rig::new();
    rig.run_ms(50);
    rig.now_us += 321;
    rig.send(&m::ClockRequest { sequence: 200 });
    rig.now_us -= 321;
    rig.tick();
    let reply: m::ClockReply = rig.last().unwrap();
    assert_eq!((reply.sequence, reply.receive_time), (200, 50_321));
    assert_eq!(reply.turnaround, 679);
}

#[test]
fn parameters_are_read_set_checked_and_reset_but_not_while_armed() {
    let mut rig = Rig::new();
    rig.run_ms(100);
    let ask = |rig: &mut Rig, set: Option<i32>| {
        match set {
            Some(value) => rig.send(&m::ParameterSet {
                identifier: 1,
                value,
            }),
            None => rig.send(&m::ParameterGet { identifier: 1 }),
        }
        rig.tick();
        let answer: m::ParameterValue = rig.last().unwrap();
        (answer.value, answer.status)
    };
    assert_eq!(ask(&mut rig, None), (300, parameter::OK));
    assert_eq!(ask(&mut rig, Some(400)), (400, parameter::OK));
    assert_eq!(ask(&mut rig, Some(10)), (400, parameter::OUT_OF_RANGE));
    rig.make_armed();
    assert_eq!(
        ask(&mut rig, Some(500)),
        (400, parameter::REFUSED_WHILE_ARMED)
    );
    rig.send(&m::Disarm { reason: 0 });
    rig.run_ms(5);
    rig.send(&m::ParameterCommand { command: 1 });
    assert_eq!(ask(&mut rig, None), (300, parameter::OK));
    rig.send(&m::ParameterGet { identifier: 999 });
    rig.tick();
    assert_eq!(
        rig.last::<m::ParameterValue>().unwrap().status,
        parameter::UNKNOWN_PARAMETER
    );
}

#[test]
fn telemetry_comes_at_its_rates_and_fits_the_line() {
    let mut rig = Rig::armed();
    rig.frames.clear();
    rig.run_ms(1_000);
    let count = |identifier: u16| {
        rig.frames
            .iter()
            .filter(|f| f.identifier == identifier)
            .count()
    };
    assert_eq!(count(m::WheelTicks::ID), 50);
    for identifier in [
        m::OdometryPosition::ID,
        m::OdometryHeading::ID,
        m::Velocity::ID,
        m::ReferenceDistance::ID,
        m::MotionStatus::ID,
    ] {
        assert_eq!(count(identifier), 20);
    }
    assert_eq!(count(m::State::ID), 10);
    assert_eq!(count(m::Battery::ID), 2);
    assert_eq!(count(m::MotorDuty::ID), 10);
    assert!((29..=31).contains(&count(m::Sonar::ID)));
    let bytes: usize = rig.frames.iter().map(|f| usize::from(f.length) + 7).sum();
    println!("{bytes} bytes/s");
    assert!(bytes < 23_040 / 4);
}

/// Bits of a frame on a CAN bus with the most stuff bits that it can have, and the gap after it.
fn worst_bits(length: usize) -> usize {
    47 + 8 * length + (34 + 8 * length - 1) / 4
}

#[test]
fn all_telemetry_with_an_inertial_sensor_leaves_most_of_a_can_bus_free() {
    let load = |inertial: bool, fastest: bool| {
        let mut rig = Rig::new();
        rig.inertial = inertial.then(|| InertialSample {
            acceleration: [0, 0, 16_393],
            ..Default::default()
        });
        rig.run_ms(2_000);
        rig.make_armed();
        if fastest {
            for message in [m::InertialHeading::ID, m::Gravity::ID] {
                rig.send(&m::TelemetryRate { message, period: 5 });
            }
        }
        rig.run_ms(10);
        rig.frames.clear();
        rig.run_ms(1_000);
        let bits: usize = rig
            .frames
            .iter()
            .map(|frame| worst_bits(usize::from(frame.length)))
            .sum();
        100.0 * bits as f64 / 500_000.0
    };
    let (without, with, fastest) = (load(false, false), load(true, false), load(true, true));
    println!(
        "CAN load {without:.1} %, with an inertial sensor {with:.1} %, at 200 Hz {fastest:.1} %"
    );
    assert!(without < with && with < fastest && fastest < 50.0);
}

#[test]
fn an_inertial_sensor_that_is_there_tells_turns_and_the_vertical_and_one_that_is_not_says_nothing()
{
    let mut rig = Rig::armed();
    rig.run_ms(1_500);
    assert!(rig.last::<m::Gravity>().is_none() && rig.last::<m::InertialHeading>().is_none());
    rig.inertial = Some(InertialSample {
        gyro: [3, -4, 50],
        acceleration: [0, 0, 16_393],
        temperature: 256,
    });
    rig.run_ms(2_000);
    let gravity = rig.last::<m::Gravity>().unwrap();
    assert_eq!(gravity.status, m::gravity_status::GOOD);
    assert!((9_780..9_830).contains(&gravity.z));
    assert!(rig.last::<m::InertialHeading>().unwrap().rate.abs() <= 1);
    rig.inertial = None;
    rig.run_ms(200);
    assert_eq!(
        rig.last::<m::Gravity>().unwrap().status,
        m::gravity_status::LOST
    );
    let fault = rig.last::<m::Fault>().unwrap();
    assert_eq!(
        (fault.code, fault.active),
        (m::fault_code::INERTIAL_LOST, 1)
    );
    assert_eq!(rig.state().state, m::state_state::ARMED);
}

#[test]
fn garbage_unknown_messages_and_wrong_lengths_only_move_counters() {
    let mut rig = Rig::armed();
    let before: m::State = rig.state();
    rig.core.receive(&[0x55; 300], rig.now_us);
    rig.core.receive(&[0], rig.now_us);
    rig.core.receive_frame(0x7ff, &[1, 2, 3], rig.now_us);
    rig.core
        .receive_frame(m::EmergencyStop::ID, &[], rig.now_us);
    rig.core.receive_frame(m::Stop::ID, &[1, 2], rig.now_us);
    rig.run_ms(1_000);
    assert_eq!(rig.state(), before);
    assert_eq!(rig.last::<m::LinkStatistics>().unwrap().malformed, 4);
}

#[test]
fn a_state_message_comes_at_once_when_something_changes() {
    let mut rig = Rig::armed();
    rig.run_ms(25);
    rig.frames.clear();
    rig.send(&m::Stop { reason: 3 });
    rig.tick();
    assert_eq!(rig.all::<m::State>().len(), 1);
}

#[test]
fn the_greeting_line_of_the_log_can_be_put_together() {
    let mut rig = Rig::new();
    rig.run_ms(50);
    let text: Vec<u8> = rig
        .all::<m::LogText>()
        .iter()
        .flat_map(|piece| piece.text)
        .collect();
    assert!(text.starts_with(b"rover firmware ready\0"));
}

#[test]
fn a_segment_without_room_waits_for_a_slot_and_is_counted_once() {
    let mut rig = Rig::armed();
    // Three seconds at rest, then 69 pieces without jerk: 64 behind the running one, five too many.
    let pieces: Vec<Piece> = (0..70).map(|_| (100_000, 0, 0)).collect();
    for part in pieces.chunks(20) {
        let first = rig.next_index;
        if first == 0 {
            rig.send_start(0, rig.now_us + 3_000_000);
        }
        for (i, piece) in (first..).zip(part) {
            rig.send_halves(i, *piece, u8::from(i == 0) | u8::from(i == 69) << 1);
        }
        rig.next_index = first + part.len() as u16;
        rig.run_ms(200);
    }
    assert_eq!((rig.status().next_index, rig.status().free_slots), (64, 0));
    let fault: m::Fault = rig.last().unwrap();
    assert_eq!((fault.code, fault.count), (fault_code::QUEUE_FULL, 1));
    assert_eq!((fault.active, fault.detail), (0, 64));
    rig.run_ms(10_000);
    assert_eq!((rig.status().next_index, rig.status().rejected), (70, 0));
    assert_eq!(rig.status().executing, 69);
}

#[test]
fn what_only_the_board_sees_is_counted_and_told() {
    let mut rig = Rig::new();
    rig.run_ms(100);
    rig.core.note_fault(fault_code::TRANSMIT_OVERFLOW, 2, 7);
    rig.core.note_bus_errors(3);
    rig.core.log_line("no CAN controller");
    rig.run_ms(1_100);
    let fault: m::Fault = rig.last().unwrap();
    assert_eq!(
        (fault.code, fault.count),
        (fault_code::TRANSMIT_OVERFLOW, 2)
    );
    assert_eq!((fault.active, fault.detail), (0, 7));
    assert_eq!(rig.last::<m::LinkStatistics>().unwrap().checksum_errors, 3);
    let pieces = rig.all::<m::LogText>();
    let text: Vec<u8> = pieces.iter().flat_map(|piece| piece.text).collect();
    assert!(text.ends_with(b"no CAN controller\0\0\0\0"));
}
