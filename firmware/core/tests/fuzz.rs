//! Bytes and measurements of every kind: no panic, nothing unbounded, and the motors only with good reason.

mod fuzz_stream;
mod rig;

use fuzz_stream::COMMANDS;
use rig::{Random, Rig};
use rover_core::{Core, Identity, InertialSample, Inputs, SonarEcho};
use rover_protocol::framing::{encode, MAX_FRAME};
use rover_protocol::messages as m;

fn drain(core: &mut Core) -> usize {
    let mut out = [0; 256];
    let mut total = 0;
    loop {
        let count = core.transmit(&mut out);
        if count == 0 {
            return total;
        }
        total += count;
        assert!(total < 2_048, "what waits to be sent is bounded");
    }
}

fn random_inputs(random: &mut Random, now_us: u64) -> Inputs {
    let sonar = (random.below(8) == 0).then(|| SonarEcho {
        sensor: random.below(5) as u8,
        echo_us: random.next() as u32 >> random.below(32),
    });
    Inputs {
        now_us,
        began_us: now_us,
        encoder_left: random.next() as i32 >> random.below(32),
        encoder_right: random.next() as i32 >> random.below(32),
        battery_mv: random.next() as u16,
        emergency_stop: random.below(500) == 0,
        bumper: random.below(50) == 0,
        sonar,
        inertial: inertial_sample(random),
    }
}

#[test]
fn random_bytes_and_measurements_never_panic_and_never_switch_the_motors_on() {
    let mut random = Random(11);
    let mut core = Core::new(Identity::default());
    let mut now_us = 0;
    for _ in 0..20_000 {
        let mut bytes = [0; 48];
        for byte in &mut bytes {
            *byte = random.next() as u8 >> random.below(9).min(7);
        }
        core.receive(&bytes[..random.below(49) as usize], now_us);
        now_us += random.below(3_000);
        let inputs = random_inputs(&mut random, now_us);
        let outputs = core.tick(&inputs);
        assert!(!outputs.powered);
        assert_eq!((outputs.duty_left, outputs.duty_right), (0, 0));
        drain(&mut core);
    }
}

#[test]
fn well_formed_frames_of_any_content_never_panic() {
    for seed in 0..8 {
        let mut random = Random(100 + seed);
        let mut core = Core::new(Identity::default());
        let mut now_us = seed << 30;
        let mut token = 0_u16;
        let (mut sequence, mut driven) = (0_u8, 0);
        let mut pinged = None;
        for _ in 0..20_000 {
            for _ in 0..random.below(4) {
                let (identifier, length) = COMMANDS[random.below(COMMANDS.len() as u64) as usize];
                // Rarely what ends everything, or no drive would ever begin.
                if matches!(identifier, 8 | 16 | 25) && random.below(50) != 0 {
                    continue;
                }
                let mut payload = random.next().to_le_bytes();
                if (64..=66).contains(&identifier) {
                    // Near the expected index, or nothing would ever be accepted.
                    payload[0] = random.below(16) as u8;
                    payload[1] = 0;
                }
                if identifier == 24 {
                    // An honest companion goes by the latest token that was seen.
                    let seen = u16::from_le_bytes([payload[0], payload[1]]);
                    token = if seen.wrapping_sub(token) < 0x8000 {
                        seen
                    } else {
                        token
                    };
                }
                let length = length + usize::from(random.below(40) == 0);
                let mut wire = [0; MAX_FRAME];
                let count = encode(identifier, sequence, &payload[..length.min(8)], &mut wire);
                sequence = sequence.wrapping_add(1);
                core.receive(&wire[..count], now_us);
            }
            if random.below(20) == 0 {
                let mut hello = [0; 6];
                hello[..4].copy_from_slice(&m::SCHEMA_HASH.to_le_bytes());
                token = token.wrapping_add(1);
                let mut arm = [0; 4];
                arm[..2].copy_from_slice(&token.to_le_bytes());
                for (identifier, payload) in [(256, &hello[..]), (24, &arm[..])] {
                    let mut wire = [0; MAX_FRAME];
                    let count = encode(identifier, sequence, payload, &mut wire);
                    sequence = sequence.wrapping_add(1);
                    core.receive(&wire[..count], now_us);
                }
            }
            now_us += 1_000;
            let mut inputs = random_inputs(&mut random, now_us);
            if seed % 2 == 0 {
                inputs.battery_mv = 7_400;
                inputs.sonar = pinged.map(|sensor| SonarEcho { sensor, echo_us: 0 });
                inputs.encoder_left = 0;
                inputs.encoder_right = 0;
            }
            let outputs = core.tick(&inputs);
            pinged = outputs.sonar_trigger;
            driven += u32::from(outputs.powered);
            drain(&mut core);
        }
        assert!(seed % 2 == 1 || driven > 1_000, "the test drives: {driven}");
    }
}

#[test]
fn the_same_bytes_and_measurements_give_the_same_answers() {
    let run = || {
        let mut rig = Rig::armed();
        rig.send_run(&rig::cruise_pieces(2_000_000, 3_000_000, 500_000), true);
        rig.run_ms(3_000);
        rig.frames
    };
    assert_eq!(run(), run());
}

#[test]
fn a_companion_that_reads_nothing_fills_no_memory() {
    let mut core = Core::new(Identity::default());
    for ms in 0..10_000 {
        let inputs = Inputs {
            now_us: ms * 1_000,
            battery_mv: 7_400,
            ..Inputs::default()
        };
        core.receive_frame(48, &[1], ms * 1_000);
        core.tick(&inputs);
    }
    assert!(drain(&mut core) > 0);
}

/// The long run is `cargo run --release -p rover-core --example fuzz -- 100000000`.
#[test]
fn two_million_bytes_of_noise_frames_and_damage_break_no_invariant_and_reach_the_motors() {
    let summary = fuzz_stream::run(2_000_000, 1);
    assert_eq!(summary.bytes, 2_000_000);
    assert!(summary.powered > 5_000, "{summary:?}");
    assert!(
        summary.bus_received > 1_000 && summary.bus_sent > 1_000,
        "{summary:?}"
    );
    assert!(summary.injected > 1_000, "{summary:?}");
    assert!(summary.segments > 100, "{summary:?}");
    assert_eq!(fuzz_stream::run(100_000, 2), fuzz_stream::run(100_000, 2));
}

/// Anything that sixteen bits may say, every fourth tick.
fn inertial_sample(random: &mut Random) -> Option<InertialSample> {
    let wide = random.below(16);
    (random.below(4) == 0).then(|| InertialSample {
        gyro: std::array::from_fn(|_| random.next() as i16 >> wide),
        acceleration: std::array::from_fn(|_| random.next() as i16 >> random.below(16)),
        temperature: random.next() as i16,
    })
}
