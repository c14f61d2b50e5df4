//! What ends a drive, how fast, and what it takes to drive again.

mod rig;

use rig::{cruise_pieces, Rig};
use rover_protocol::messages as m;
use rover_protocol::messages::{fault_code, state_cause as cause, state_state as state};
use rover_protocol::Message;

/// Cruising at 0.25 m/s in the middle of a long straight.
fn cruising() -> Rig {
    let mut rig = Rig::armed();
    rig.send_run(&cruise_pieces(3_000_000, 0, 8_000_000), true);
    rig.run_ms(1_500);
    assert_eq!(rig.state().state, state::MOVING);
    assert!((rig.motors[0].velocity - 0.25).abs() < 0.02);
    rig
}

/// The way and time from now until the motors are off; checks that the speed falls without a jump.
fn stop_way(rig: &mut Rig) -> (f64, u64) {
    let from = rig.driven().0;
    let mut ms = 0;
    while rig.outputs.powered {
        let before = rig.motors[0].velocity;
        rig.tick();
        let change = rig.motors[0].velocity - before;
        assert!(change.abs() < 3e-3, "no jump of speed: {change}");
        ms += 1;
        assert!(ms < 3_000);
    }
    (rig.driven().0 - from, ms)
}

#[test]
fn boots_into_disarmed_with_the_motors_off() {
    let mut rig = Rig::new();
    rig.run_ms(9);
    assert_eq!(rig.state().state, state::BOOT);
    rig.run_ms(5);
    assert_eq!(rig.state().state, state::DISARMED);
    assert!(!rig.outputs.powered);
}

#[test]
fn arming_needs_a_handshake_a_battery_a_released_emergency_stop_and_a_new_token() {
    let mut rig = Rig::new();
    rig.run_ms(100);
    rig.arm();
    rig.run_ms(2);
    assert_eq!(rig.state().state, state::DISARMED);
    let fault: m::Fault = rig.last().unwrap();
    assert_eq!((fault.code, fault.detail), (fault_code::ARM_REFUSED, 1));

    rig.send(&m::Hello {
        schema_hash: m::SCHEMA_HASH,
        session: 1,
    });
    rig.send(&m::Arm {
        token: 1,
        session: 1,
    });
    rig.run_ms(2);
    assert_eq!(
        rig.state().state,
        state::DISARMED,
        "the refused token was seen"
    );
    assert_eq!(rig.state().arm_token, 1);

    rig.battery_mv = 6_000;
    rig.run_ms(500);
    rig.arm();
    rig.run_ms(200);
    assert_eq!(rig.state().state, state::DISARMED);
    rig.battery_mv = 7_400;
    rig.run_ms(500);
    rig.arm();
    rig.run_ms(2);
    assert_eq!(rig.state().state, state::ARMED);
    assert!(rig.outputs.powered);
}

#[test]
fn the_emergency_stop_input_takes_the_duty_away_within_the_same_tick() {
    let mut rig = cruising();
    assert!(rig.outputs.duty_left > 10_000);
    rig.emergency_stop = true;
    let outputs = rig.tick();
    assert_eq!((outputs.duty_left, outputs.duty_right), (0, 0));
    assert!(!outputs.powered);
    assert_eq!(rig.state().state, state::LATCHED);
    assert_eq!(rig.state().cause, cause::EMERGENCY_INPUT);
    rig.arm();
    rig.run_ms(2);
    assert_eq!(rig.state().state, state::LATCHED, "not while it is pressed");
    rig.emergency_stop = false;
    rig.run_ms(2);
    assert_eq!(rig.state().state, state::LATCHED, "not by releasing it");
    rig.arm();
    rig.run_ms(2);
    assert_eq!(rig.state().state, state::ARMED);
}

#[test]
fn the_emergency_command_acts_in_the_next_tick_and_in_every_state() {
    let mut rig = cruising();
    rig.send(&m::EmergencyStop { reason: 42 });
    let outputs = rig.tick();
    assert_eq!((outputs.duty_left, outputs.duty_right), (0, 0));
    assert!(!outputs.powered);
    let state = rig.state();
    assert_eq!(
        (state.state, state.cause),
        (state::LATCHED, cause::EMERGENCY_COMMAND)
    );
    assert_eq!(state.cause_detail, 42);
    let mut rig = Rig::new();
    rig.send(&m::EmergencyStop { reason: 1 });
    rig.run_ms(20);
    assert_eq!(rig.state().state, state::LATCHED, "even while booting");
}

#[test]
fn silence_stops_the_rover_after_the_dead_man_time_without_a_jerk_and_latches() {
    let mut rig = cruising();
    rig.keep_alive = false;
    let silent_ms = rig.run_until_state(state::STOPPING);
    assert!((250..=301).contains(&silent_ms), "{silent_ms}");
    let (way, ms) = stop_way(&mut rig);
    // v/a + a/j = 446 ms and half of that at 0.25 m/s.
    assert!((440..=560).contains(&ms), "{ms} ms");
    assert!((way - 0.0557).abs() < 0.004, "{way} m");
    let state = rig.state();
    assert_eq!(
        (state.state, state.cause),
        (state::LATCHED, cause::DEAD_MAN)
    );
    assert_ne!(state.faults & 1 << fault_code::DEAD_MAN, 0);
}

#[test]
fn silence_while_armed_and_idle_latches_and_switches_the_motors_off() {
    let mut rig = Rig::armed();
    rig.keep_alive = false;
    rig.run_ms(310);
    assert_eq!(rig.state().state, state::LATCHED);
    assert_eq!(rig.state().cause, cause::DEAD_MAN);
    assert!(!rig.outputs.powered);
}

#[test]
fn a_keep_alive_that_does_not_count_up_does_not_feed_the_dead_man() {
    let mut rig = Rig::armed();
    rig.keep_alive = false;
    for _ in 0..40 {
        rig.send(&m::KeepAlive { counter: 9 });
        rig.run_ms(10);
    }
    assert_eq!(rig.state().state, state::LATCHED);
}

#[test]
fn accepted_motion_feeds_the_dead_man_and_repeated_motion_does_not() {
    let mut rig = Rig::armed();
    rig.keep_alive = false;
    rig.send_run(&[(20_000, 0, 0)], false);
    for index in 1..60 {
        rig.send_halves(index, (20_000, 0, 0), 0);
        rig.run_ms(20);
    }
    assert_eq!(rig.state().state, state::MOVING);
    for _ in 0..40 {
        rig.send_halves(59, (20_000, 0, 0), 0);
        rig.run_ms(10);
    }
    assert_eq!(rig.state().state, state::LATCHED);
}

#[test]
fn only_a_new_token_releases_the_latch_and_a_repeated_one_never_does() {
    let mut rig = cruising();
    rig.send(&m::Stop { reason: 5 });
    rig.run_until_state(state::LATCHED);
    assert_eq!(
        (rig.state().cause, rig.state().cause_detail),
        (cause::STOP_COMMAND, 5)
    );
    let token = rig.state().arm_token;
    for _ in 0..5 {
        rig.send(&m::Arm { token, session: 1 });
        rig.run_ms(10);
    }
    assert_eq!(rig.state().state, state::LATCHED);
    rig.arm();
    rig.run_ms(2);
    let state = rig.state();
    assert_eq!(
        (state.state, state.cause, state.faults),
        (state::ARMED, cause::NONE, 0)
    );
}

#[test]
fn disarm_stops_without_a_jerk_and_without_a_latch() {
    let mut rig = cruising();
    rig.send(&m::Disarm { reason: 0 });
    stop_way(&mut rig);
    assert_eq!(rig.state().state, state::DISARMED);
    assert_eq!(rig.state().cause, cause::DISARM);
}

#[test]
fn a_stop_in_the_middle_of_a_turn_brings_both_axes_to_rest() {
    let mut rig = Rig::armed();
    rig.send_run(&cruise_pieces(2_000_000, 6_000_000, 4_000_000), true);
    rig.run_ms(1_500);
    rig.send(&m::Stop { reason: 0 });
    rig.run_until_state(state::LATCHED);
    let velocity: m::Velocity = {
        rig.run_ms(60);
        rig.last().unwrap()
    };
    assert_eq!(
        (velocity.reference_travel, velocity.reference_heading),
        (0, 0)
    );
    assert!(rig.motors.iter().all(|motor| motor.velocity.abs() < 0.02));
}

#[test]
fn motion_that_runs_dry_stops_and_latches_as_underrun() {
    let mut rig = Rig::armed();
    rig.send_run(&cruise_pieces(3_000_000, 0, 500_000)[..4], false);
    rig.run_until_state(state::STOPPING);
    stop_way(&mut rig);
    assert_eq!(
        (rig.state().state, rig.state().cause),
        (state::LATCHED, cause::UNDERRUN)
    );
}

#[test]
fn a_low_battery_stops_the_rover_after_its_delay() {
    let mut rig = cruising();
    rig.battery_mv = 6_000;
    let ms = rig.run_until_state(state::STOPPING);
    assert!((500..700).contains(&ms), "{ms}");
    rig.run_until_state(state::LATCHED);
    assert_eq!(rig.state().cause, cause::LOW_BATTERY);
}

#[test]
fn an_obstacle_ahead_stops_the_rover_before_the_footprint_touches_it() {
    let mut rig = cruising();
    // A wall that comes nearer as the rover drives; the sensor sits 0.12 m ahead of the middle, the rim 0.15 m.
    let wall = rig.driven().0 + 0.12 + 0.60;
    while rig.outputs.powered {
        let range = wall - 0.12 - rig.driven().0;
        rig.ranges_mm[1] = Some((range * 1e3) as u32);
        rig.tick();
        assert!(rig.now_us < 20_000_000);
    }
    let clearance = wall - 0.15 - rig.driven().0;
    println!("stopped {:.0} mm before the wall", clearance * 1e3);
    assert!((0.01..0.08).contains(&clearance), "{clearance}");
    let state = rig.state();
    assert_eq!(
        (state.state, state.cause, state.cause_detail),
        (state::LATCHED, cause::SONAR_GUARD, 1)
    );
}

#[test]
fn a_blocked_wheel_is_a_stall_and_cuts_the_motors() {
    let mut rig = cruising();
    rig.motors[1].blocked = true;
    let ms = rig.run_until_state(state::LATCHED);
    assert!(ms < 600, "{ms}");
    assert_eq!(
        (rig.state().cause, rig.state().cause_detail),
        (cause::STALL, 1)
    );
}

#[test]
fn an_encoder_that_never_counts_is_told_from_a_stall() {
    let mut rig = Rig::armed();
    rig.motors[0].kill_encoder();
    rig.send_run(&cruise_pieces(3_000_000, 0, 3_000_000), true);
    let ms = rig.run_until_state(state::LATCHED);
    assert_eq!(
        (rig.state().cause, rig.state().cause_detail),
        (cause::ENCODER_FAULT, 0)
    );
    assert_ne!(rig.state().faults & 1 << fault_code::ENCODER_LEFT, 0);
    assert!(ms < 1_000, "{ms}");
}

#[test]
fn an_encoder_that_jumps_cuts_the_motors_at_once() {
    let mut rig = cruising();
    rig.motors[1].position += 0.05;
    rig.tick();
    assert_eq!(
        (rig.state().cause, rig.state().cause_detail),
        (cause::ENCODER_FAULT, 1)
    );
    assert!(!rig.outputs.powered);
}

#[test]
fn a_control_loop_that_was_held_up_cuts_the_motors() {
    let mut rig = cruising();
    rig.now_us += 60_000;
    rig.tick();
    assert_eq!(
        (rig.state().state, rig.state().cause),
        (state::LATCHED, cause::INTERNAL)
    );
}

#[test]
fn a_reboot_is_carried_out_disarmed_and_refused_while_armed() {
    let ask = |rig: &mut Rig, magic: u32, session: u16| {
        rig.send(&m::Reboot { magic, session });
        rig.core.take_reboot()
    };
    let (restart, bootloader) = (0x5242_4F54, 0x424F_4F54);
    let mut rig = Rig::armed();
    assert_eq!(ask(&mut rig, restart, rig::SESSION), None);
    rig.send(&m::Disarm { reason: 0 });
    rig.run_ms(5);
    assert_eq!(ask(&mut rig, 0x1234_5678, rig::SESSION), None);
    assert_eq!(ask(&mut rig, bootloader, 99), None, "another session");
    let [a, b, c, d] = u32::to_le_bytes(restart);
    let frame = [a, b, c, d, rig::SESSION as u8, 0];
    rig.core.receive_frame(m::Reboot::ID, &frame, rig.now_us);
    assert_eq!(rig.core.take_reboot(), None, "another wire");
    assert_eq!(
        ask(&mut rig, bootloader, rig::SESSION),
        Some(rover_core::Reboot::Bootloader)
    );
    assert_eq!(rig.core.take_reboot(), None);
}

/// At 0.1 m/s in the middle of a straight.
fn creeping() -> Rig {
    let mut rig = Rig::armed();
    rig.send_run(&cruise_pieces(1_200_000, 0, 8_000_000), true);
    rig.run_ms(1_500);
    assert!((rig.motors[0].velocity - 0.1).abs() < 0.01);
    rig
}

#[test]
fn a_touch_of_the_bumper_takes_the_duty_away_at_once_and_brakes_to_rest_within_10_mm() {
    let mut rig = creeping();
    let from = rig.driven().0;
    rig.bumper = true;
    let outputs = rig.tick();
    assert_eq!((outputs.duty_left, outputs.duty_right), (0, 0));
    assert!(outputs.powered, "shorted motors brake, open ones coast");
    let state = rig.state();
    assert_eq!((state.state, state.cause), (state::LATCHED, cause::BUMPER));
    assert_eq!(state.flags >> 5 & 1, 1);
    rig.run_ms(400);
    assert!(!rig.outputs.powered);
    assert!(rig.driven().0 - from < 0.010, "{}", rig.driven().0 - from);
}

#[test]
fn with_a_pressed_bumper_the_way_out_is_back_or_a_turn_and_never_forward() {
    for (travel, heading, allowed) in [
        (-600_000, 0, true),
        (0, 3_000_000, true),
        (600_000, 0, false),
    ] {
        let mut rig = creeping();
        rig.bumper = true;
        rig.run_ms(500);
        rig.arm();
        rig.run_ms(2);
        assert_eq!(rig.state().state, state::ARMED);
        rig.next_index = rig.status().next_index;
        rig.send_run(&cruise_pieces(travel, heading, 100_000), true);
        rig.run_ms(500);
        let moving = rig.state().state == state::MOVING;
        assert_eq!(moving, allowed, "{travel} {heading} {:?}", rig.state());
    }
}

#[test]
fn switches_that_chatter_while_the_rover_backs_away_are_no_touch() {
    let mut rig = Rig::armed();
    rig.send_run(&cruise_pieces(-1_200_000, 0, 1_000_000), true);
    rig.run_ms(200);
    for ms in 0..200 {
        rig.bumper = ms % 7 < 3;
        rig.tick();
    }
    assert_eq!(rig.state().state, state::MOVING);
}

#[test]
fn the_emergency_stop_overrides_the_braking_after_a_touch() {
    let mut rig = cruising();
    rig.bumper = true;
    rig.tick();
    assert!(rig.outputs.powered);
    rig.emergency_stop = true;
    rig.tick();
    assert!(!rig.outputs.powered);
}
