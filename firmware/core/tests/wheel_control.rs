//! How well the wheels follow the reference, with motors that the feed-forward does not know exactly.

mod rig;

use rig::{cruise_pieces, MotorKind, Piece, Rig, HEAVY, LIGHT};
use rover_protocol::messages as m;

struct Tracking {
    /// Worst distance between reference and wheels while driving, m.
    travel: f64,
    /// rad.
    heading: f64,
    /// How often the duty changed its sign in the last second, at rest.
    reversals: usize,
    /// Rest of both at the end.
    travel_end: f64,
    heading_end: f64,
}

/// Drive a run and compare what the motors really did with the reference that the firmware reports every 5 ms.
fn track(kind: MotorKind, battery_mv: u16, spread: f64, pieces: &[Piece]) -> Tracking {
    let mut rig = Rig::with_motors(kind);
    rig.battery_mv = battery_mv;
    rig.motors[0].kind.top_speed *= 1.0 + spread;
    rig.motors[1].kind.top_speed *= 1.0 - spread;
    rig.make_armed();
    rig.send(&m::TelemetryRate {
        message: 116,
        period: 5,
    });
    rig.send_run(pieces, true);
    let duration_ms = pieces.iter().map(|p| u64::from(p.0)).sum::<u64>() / 1000 + 1_300;
    let mut tracking = Tracking {
        travel: 0.0,
        heading: 0.0,
        reversals: 0,
        travel_end: 0.0,
        heading_end: 0.0,
    };
    let mut last_duty = 0;
    for ms in 0..duration_ms {
        // The reference of a tick is for the state before the motors' step.
        let driven = rig.driven();
        let before = rig.frames.len();
        let outputs = rig.tick();
        let fresh = rig.frames[before..].iter().any(|f| f.identifier == 116);
        if fresh {
            let reference: m::ReferenceDistance = rig.last().unwrap();
            tracking.travel_end = driven.0 - f64::from(reference.travel) / 1e5;
            tracking.heading_end = driven.1 - f64::from(reference.heading) / 1e6;
            tracking.travel = tracking.travel.max(tracking.travel_end.abs());
            tracking.heading = tracking.heading.max(tracking.heading_end.abs());
        }
        if ms > duration_ms - 1_000 {
            let turned = i32::from(outputs.duty_left.signum()) * last_duty < 0;
            tracking.reversals += usize::from(turned);
        }
        if outputs.duty_left != 0 {
            last_duty = i32::from(outputs.duty_left.signum());
        }
    }
    assert_eq!(
        rig.state().state,
        m::state_state::ARMED,
        "{:?}",
        rig.state()
    );
    tracking
}

fn assert_tracks(name: &str, tracking: &Tracking) {
    println!(
        "{name}: travel {:.2} mm, heading {:.2} mrad, at the end {:.2} mm {:.2} mrad, {} reversals at rest",
        tracking.travel * 1e3,
        tracking.heading * 1e3,
        tracking.travel_end * 1e3,
        tracking.heading_end * 1e3,
        tracking.reversals
    );
    assert!(tracking.travel < 3e-3, "{name}");
    assert!(tracking.heading < 10e-3, "{name}");
    assert!(tracking.travel_end.abs() < 0.5e-3, "{name}");
    assert!(tracking.heading_end.abs() < 4e-3, "{name}");
    assert!(tracking.reversals <= 2, "{name}");
}

fn straight() -> Vec<Piece> {
    cruise_pieces(3_000_000, 0, 2_000_000)
}

fn turn() -> Vec<Piece> {
    cruise_pieces(0, 8_000_000, 800_000)
}

fn arc() -> Vec<Piece> {
    cruise_pieces(2_500_000, 4_000_000, 1_500_000)
}

#[test]
fn a_straight_a_turn_on_the_spot_and_an_arc_are_followed_by_a_typical_motor() {
    assert_tracks("straight", &track(HEAVY, 7_400, 0.0, &straight()));
    assert_tracks("turn", &track(HEAVY, 7_400, 0.0, &turn()));
    assert_tracks("arc", &track(HEAVY, 7_400, 0.0, &arc()));
}

/// Standard deviation of the wheel's true velocity and of the duty (-1 to 1) in the middle of a cruise.
fn ripple(kind: MotorKind) -> (f64, f64) {
    let mut rig = Rig::with_motors(kind);
    rig.make_armed();
    rig.send_run(&cruise_pieces(3_000_000, 0, 4_000_000), true);
    rig.run_ms(2_000);
    let mut samples = vec![];
    for _ in 0..2_000 {
        let outputs = rig.tick();
        samples.push((
            rig.motors[0].velocity,
            f64::from(outputs.duty_left) / 32_768.0,
        ));
    }
    let deviation = |values: Vec<f64>| {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let square = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>();
        (square / values.len() as f64).sqrt()
    };
    (
        deviation(samples.iter().map(|s| s.0).collect()),
        deviation(samples.iter().map(|s| s.1).collect()),
    )
}

#[test]
fn a_steady_cruise_is_steady() {
    for (name, kind) in [("typical", HEAVY), ("brisk", LIGHT)] {
        let (velocity, duty) = ripple(kind);
        println!(
            "{name}: ripple {:.2} mm/s, duty {:.2} %",
            velocity * 1e3,
            duty * 1e2
        );
        assert!(velocity < 1.5e-3, "{name}: {velocity}");
        assert!(duty < 0.02, "{name}: {duty}");
    }
}

#[test]
fn a_brisk_motor_is_followed_as_well_with_the_same_gains() {
    assert_tracks("straight", &track(LIGHT, 7_400, 0.0, &straight()));
    assert_tracks("turn", &track(LIGHT, 7_400, 0.0, &turn()));
    assert_tracks("arc", &track(LIGHT, 7_400, 0.0, &arc()));
}

#[test]
fn full_and_empty_batteries_change_nothing() {
    for (name, battery_mv) in [("8.4 V", 8_400), ("6.5 V", 6_500)] {
        assert_tracks(name, &track(HEAVY, battery_mv, 0.0, &straight()));
        assert_tracks(name, &track(LIGHT, battery_mv, 0.0, &arc()));
    }
}

#[test]
fn motors_that_differ_by_six_percent_still_drive_straight() {
    assert_tracks("spread", &track(HEAVY, 7_400, 0.03, &straight()));
    assert_tracks("spread", &track(LIGHT, 7_400, 0.03, &straight()));
}

#[test]
fn friction_twice_as_high_as_expected_is_made_up_for() {
    let stiff = MotorKind {
        friction: 0.14,
        ..HEAVY
    };
    assert_tracks("stiff", &track(stiff, 7_400, 0.0, &straight()));
}
