//! Test mode: the whole drive happens inside, and nothing of it reaches the pins.

mod rig;

use rig::{cruise_pieces, Rig};
use rover_core::Outputs;
use rover_protocol::messages as m;
use rover_protocol::messages::{state_cause as cause, state_state as state};

const BEGIN: m::TestMode = m::TestMode {
    enable: 1,
    key: 0x5445,
};
const END: m::TestMode = m::TestMode { enable: 0, key: 0 };
const TEST_FLAG: u8 = 1 << 4;
const QUIET: m::InjectSensors = m::InjectSensors {
    battery: 7_400,
    emergency_stop: 0,
    bumper: 0,
    sonar: 255,
    echo: 0,
};

/// A board on a desk, greeted and in test mode; its own pins show a flat battery, which must not matter.
fn in_test_mode() -> Rig {
    let mut rig = Rig::new();
    rig.run_ms(100);
    rig.send(&m::Hello {
        schema_hash: m::SCHEMA_HASH,
        session: 1,
    });
    rig.send(&BEGIN);
    rig.battery_mv = 0;
    rig.run_ms(1);
    assert_eq!(rig.state().flags & TEST_FLAG, TEST_FLAG);
    rig
}

/// One tick with what the injector sends; the wheels turn as they were told, 3.4 counts a ms at full duty.
fn tick(rig: &mut Rig, counts: &mut [f64; 2], sensors: &m::InjectSensors) -> Outputs {
    let duty: m::MotorDuty = rig.last().unwrap_or_default();
    for (count, duty) in counts.iter_mut().zip([duty.left, duty.right]) {
        *count += f64::from(duty) / 32_768.0 * 3.4;
    }
    let [left, right] = counts.map(|count| count as i32);
    rig.send(&m::InjectWheels { left, right });
    if rig.now_us.is_multiple_of(20_000) {
        rig.send(sensors);
    }
    let outputs = rig.tick();
    assert!(!outputs.powered);
    assert_eq!((outputs.duty_left, outputs.duty_right), (0, 0));
    assert_eq!(outputs.sonar_trigger, None);
    outputs
}

fn run_until(rig: &mut Rig, counts: &mut [f64; 2], sensors: &m::InjectSensors, wanted: u8) {
    for _ in 0..4_000 {
        tick(rig, counts, sensors);
        if rig.state().state == wanted {
            return;
        }
    }
    panic!("state {wanted} did not come, it is {:?}", rig.state());
}

/// Armed, with the duty reported in every fifth tick.
fn armed(counts: &mut [f64; 2]) -> Rig {
    let mut rig = in_test_mode();
    rig.send(&m::TelemetryRate {
        message: 145,
        period: 5,
    });
    tick(&mut rig, counts, &QUIET);
    rig.arm();
    run_until(&mut rig, counts, &QUIET, state::ARMED);
    rig
}

#[test]
fn a_run_is_driven_on_injected_wheels_while_the_pins_stay_dead() {
    // A board that was moved by hand before: absolute counts may begin anywhere.
    let mut counts = [1_000_000.0, -70_000.0];
    let mut rig = armed(&mut counts);
    rig.send_run(&cruise_pieces(3_000_000, 0, 1_000_000), true);
    run_until(&mut rig, &mut counts, &QUIET, state::MOVING);
    let mut most = 0;
    while rig.state().state == state::MOVING {
        tick(&mut rig, &mut counts, &QUIET);
        most = most.max(rig.last::<m::MotorDuty>().unwrap().left);
    }
    assert_eq!(rig.state().state, state::ARMED);
    assert!(
        most > 15_000,
        "what the controller wants is reported: {most}"
    );
    let driven = counts.map(|count| count.abs()).iter().sum::<f64>();
    assert!(driven > 1_000_000.0 + 70_000.0, "{driven}");
    let x: m::OdometryPosition = rig.last().unwrap();
    assert!((x.x - 41_666).abs() < 500, "{x:?}");
    // It is the injected battery that is measured.
    assert!(rig.last::<m::Battery>().unwrap().voltage > 7_300);
}

#[test]
fn it_is_refused_while_armed_before_the_handshake_and_without_its_key() {
    let mut rig = Rig::armed();
    rig.send(&BEGIN);
    rig.run_ms(10);
    assert_eq!(rig.state().flags & TEST_FLAG, 0);
    assert!(rig.outputs.powered);

    let mut rig = Rig::new();
    rig.run_ms(100);
    rig.send(&BEGIN);
    rig.run_ms(10);
    assert_eq!(rig.state().flags & TEST_FLAG, 0, "a stranger");
    rig.send(&m::Hello {
        schema_hash: m::SCHEMA_HASH,
        session: 1,
    });
    rig.send(&m::TestMode { enable: 1, key: 0 });
    rig.send(&m::InjectWheels { left: 1, right: 1 });
    rig.run_ms(1_100);
    assert_eq!(rig.state().flags & TEST_FLAG, 0);
    assert_eq!(rig.last::<m::LinkStatistics>().unwrap().malformed, 2);
}

#[test]
fn it_ends_only_when_disarmed_and_the_jump_back_to_the_real_wheels_is_no_way() {
    let mut counts = [0.0; 2];
    let mut rig = armed(&mut counts);
    rig.send(&END);
    tick(&mut rig, &mut counts, &QUIET);
    assert_eq!(rig.state().flags & TEST_FLAG, TEST_FLAG, "armed");
    rig.send(&m::Disarm { reason: 0 });
    run_until(&mut rig, &mut counts, &QUIET, state::DISARMED);
    let before: m::OdometryPosition = rig.last().unwrap();
    rig.battery_mv = 7_400;
    rig.motors[0].position = 5.0;
    rig.send(&END);
    rig.run_ms(100);
    assert_eq!(rig.state().flags & TEST_FLAG, 0);
    assert_eq!(rig.last::<m::OdometryPosition>().unwrap(), before);
    rig.arm();
    rig.run_ms(20);
    assert!(rig.outputs.powered, "and the motors may be had again");
}

#[test]
fn an_injector_that_falls_silent_ends_it_and_latches_whatever_the_state() {
    for arm in [false, true] {
        let mut counts = [0.0; 2];
        let mut rig = armed(&mut counts);
        rig.battery_mv = 7_400;
        if !arm {
            rig.send(&m::Disarm { reason: 0 });
            run_until(&mut rig, &mut counts, &QUIET, state::DISARMED);
        }
        for _ in 0..299 {
            assert!(!rig.tick().powered);
        }
        assert_eq!(rig.state().flags & TEST_FLAG, TEST_FLAG);
        for _ in 0..1_000 {
            assert!(!rig.tick().powered);
        }
        let now = rig.state();
        assert_eq!(
            (now.state, now.cause),
            (state::LATCHED, cause::INJECTOR_SILENT)
        );
        assert_eq!(now.flags & TEST_FLAG, 0);
    }
}

#[test]
fn the_real_emergency_stop_counts_beside_the_injected_one() {
    let pressed = m::InjectSensors {
        emergency_stop: 1,
        ..QUIET
    };
    for (real, injected) in [(true, &QUIET), (false, &pressed)] {
        let mut counts = [0.0; 2];
        let mut rig = armed(&mut counts);
        rig.emergency_stop = real;
        run_until(&mut rig, &mut counts, injected, state::LATCHED);
        assert_eq!(rig.state().cause, cause::EMERGENCY_INPUT);
    }
}

#[test]
fn injected_echoes_answer_the_pings_and_stop_the_rover() {
    let mut counts = [0.0; 2];
    let mut rig = armed(&mut counts);
    rig.send_run(&cruise_pieces(3_000_000, 0, 5_000_000), true);
    run_until(&mut rig, &mut counts, &QUIET, state::MOVING);
    for _ in 0..1_500 {
        tick(&mut rig, &mut counts, &QUIET);
    }
    let near = m::InjectSensors {
        sonar: 1,
        echo: 700,
        ..QUIET
    };
    run_until(&mut rig, &mut counts, &near, state::LATCHED);
    assert_eq!(
        (rig.state().cause, rig.state().cause_detail),
        (cause::SONAR_GUARD, 1)
    );
    let all = rig.all::<m::Sonar>();
    assert!(
        all.iter().any(|s| s.sensor == 1 && s.range == 120),
        "{all:?}"
    );
    assert!(all.iter().filter(|s| s.sensor != 1).all(|s| s.status == 1));

    let broken = m::InjectSensors {
        sonar: 2,
        echo: 0xff_ffff,
        ..QUIET
    };
    for _ in 0..1_200 {
        tick(&mut rig, &mut counts, &broken);
    }
    assert_ne!(rig.state().faults & 1 << m::fault_code::SONAR_DEAD, 0);
}
