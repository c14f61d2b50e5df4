//! The executed motion against closed forms in floating point, and the rules of the queue.

use super::*;

const LIMITS: MotionLimits = MotionLimits {
    travel: Limits {
        velocity: 500_000,
        acceleration: 1_500_000,
    },
    heading: Limits {
        velocity: 2_500_000,
        acceleration: 8_000_000,
    },
    stop_travel: (800_000, 6_000_000),
    stop_heading: (4_000_000, 8_000_000),
    wheel: 450_000,
    half_track_um: 100_000,
};

/// SplitMix64.
struct Random(u64);

impl Random {
    fn below(&mut self, bound: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ (z >> 31)) % bound
    }
}

/// Speed up, drive on, slow down: seven segments whose jerks and durations are random, ending at rest.
fn random_run(random: &mut Random, first_index: u16) -> Vec<Segment> {
    let ramp = 20_000 + random.below(180_000) as u32;
    let hold = 1_000 + random.below(150_000) as u32;
    let cruise = 1_000 + random.below(2_000_000) as u32;
    let jerk = |random: &mut Random, peak: u64| random.below(2 * peak + 1) as i32 - peak as i32;
    let (travel, heading) = (jerk(random, 3_000_000), jerk(random, 8_000_000));
    let shape = [1, 0, -1, 0, -1, 0, 1];
    let durations = [ramp, hold, ramp, cruise, ramp, hold, ramp];
    (0..7)
        .map(|i| {
            let flags = u8::from(i == 0) | u8::from(i == 6) << 1;
            let index = first_index.wrapping_add(i as u16);
            Segment::new(
                index,
                durations[i],
                shape[i] * travel,
                shape[i] * heading,
                flags,
            )
        })
        .collect()
}

/// Position, velocity and acceleration of one axis in SI units, by the closed form.
fn closed_form(jerks: &[(f64, f64)], time: f64) -> (f64, f64) {
    let (mut p, mut v, mut a, mut left) = (0.0, 0.0, 0.0, time);
    for (duration, jerk) in jerks {
        let t = left.min(*duration);
        p += v * t + a * t * t / 2.0 + jerk * t * t * t / 6.0;
        v += a * t + jerk * t * t / 2.0;
        a += jerk * t;
        left -= t;
    }
    (p, v)
}

fn axis_jerks(run: &[Segment], jerk: impl Fn(&Segment) -> i64) -> Vec<(f64, f64)> {
    run.iter()
        .map(|s| (f64::from(s.duration_us) / 1e6, jerk(s) as f64 / 1e6))
        .collect()
}

fn accept_run(motion: &mut Motion, run: &[Segment], start_us: u64) {
    for segment in run {
        let start = segment.begins.then_some(start_us);
        assert_eq!(motion.accept(*segment, start, &LIMITS), Ok(()));
    }
}

#[test]
fn a_thousand_random_runs_follow_the_closed_form_to_twenty_nanometres_at_every_tick() {
    let mut random = Random(1);
    let mut worst = 0.0_f64;
    for _ in 0..1_000 {
        let run = random_run(&mut random, 0);
        let mut motion = Motion::default();
        let start_us = 5_000 + random.below(1_000);
        accept_run(&mut motion, &run, start_us);
        let travel = axis_jerks(&run, |s| s.jerk_travel);
        let heading = axis_jerks(&run, |s| s.jerk_heading);
        let mut now_us = 0;
        loop {
            // Ticks need not be even.
            now_us += 900 + random.below(200);
            let progress = motion.advance(now_us);
            let time = now_us.saturating_sub(start_us) as f64 / 1e6;
            for (axis, jerks) in [
                (motion.reference().travel, &travel),
                (motion.reference().heading, &heading),
            ] {
                let (p, v) = closed_form(jerks, time);
                worst = worst.max((axis.position_nano() as f64 / 1e9 - p).abs());
                assert!((axis.velocity_micro() as f64 / 1e6 - v).abs() < 1.1e-6);
            }
            if progress == Progress::Idle && now_us > start_us {
                break;
            }
        }
        assert!(motion.reference().at_rest());
    }
    // Each boundary rounds the acceleration down by at most 1e-15 m/tick^2.
    assert!(worst < 20e-9, "{worst}");
}

#[test]
fn the_end_of_a_run_does_not_depend_on_where_the_ticks_fall() {
    let run = random_run(&mut Random(7), 0);
    let end = |start_us: u64, period_us: u64| {
        let mut motion = Motion::default();
        accept_run(&mut motion, &run, start_us);
        for tick in 1..20_000 {
            motion.advance(tick * period_us);
        }
        *motion.reference()
    };
    let expected = end(10_000, 1_000);
    assert_eq!(end(10_337, 1_000), expected);
    assert_eq!(end(10_999, 1_003), expected);
    assert_eq!(end(12_345, 997), expected);
}

#[test]
fn rest_makes_velocity_and_acceleration_exactly_zero() {
    let mut motion = Motion::default();
    // The jerks leave 1 um/s^2 and a little velocity over.
    let run = [
        Segment::new(0, 100_003, 1_000_000, 0, 1),
        Segment::new(1, 100_002, -1_000_000, 0, 0),
        Segment::new(2, 100_003, -1_000_000, 0, 0),
        Segment::new(3, 100_001, 1_000_000, 0, 2),
    ];
    accept_run(&mut motion, &run, 1_000);
    for ms in 1..500 {
        motion.advance(ms * 1000);
    }
    assert!(motion.reference().at_rest());
    assert_eq!(motion.queued(), 0);
}

#[test]
fn a_segment_that_claims_to_rest_and_does_not_is_refused() {
    let mut motion = Motion::default();
    accept_run(
        &mut motion,
        &[Segment::new(0, 300_000, 1_000_000, 0, 1)],
        1_000,
    );
    let lie = Segment::new(1, 10_000, 0, 0, 2);
    assert_eq!(motion.accept(lie, None, &LIMITS), Err(Refusal::NotAtRest));
}

#[test]
fn segments_beyond_the_limits_or_shorter_than_a_millisecond_are_refused() {
    let mut motion = Motion::default();
    let mut refusal = |duration_us, travel, heading| {
        let segment = Segment::new(0, duration_us, travel, heading, 1);
        motion.accept(segment, Some(1_000), &LIMITS).unwrap_err()
    };
    assert_eq!(refusal(999, 0, 0), Refusal::TooShort);
    assert_eq!(refusal(600_000, 3_000_000, 0), Refusal::BeyondLimits);
    assert_eq!(refusal(16_777_215, 8_388_607, 0), Refusal::BeyondLimits);
    assert_eq!(refusal(16_777_215, 0, -8_388_608), Refusal::BeyondLimits);
    assert_eq!(refusal(900_000, 0, 8_000_000), Refusal::BeyondLimits);
}

#[test]
fn a_run_begins_with_begin_and_another_only_after_a_rest() {
    let mut motion = Motion::default();
    let orphan = Segment::new(0, 100_000, 0, 0, 0);
    assert_eq!(
        motion.accept(orphan, None, &LIMITS),
        Err(Refusal::NotContinuous)
    );
    let moving = Segment::new(0, 100_000, 1_000_000, 0, 1);
    assert_eq!(motion.accept(moving, Some(50_000), &LIMITS), Ok(()));
    let inside = Segment::new(1, 100_000, 0, 0, 1);
    assert_eq!(
        motion.accept(inside, Some(400_000), &LIMITS),
        Err(Refusal::NotContinuous)
    );
}

#[test]
fn two_runs_may_wait_behind_each_other_but_not_overlap() {
    let mut motion = Motion::default();
    let first = random_run(&mut Random(3), 0);
    let second = random_run(&mut Random(4), 7);
    let end_us = 1_000 + first.iter().map(|s| u64::from(s.duration_us)).sum::<u64>();
    accept_run(&mut motion, &first, 1_000);
    assert_eq!(
        motion.accept(second[0], Some(end_us - 1), &LIMITS),
        Err(Refusal::StartPassed)
    );
    accept_run(&mut motion, &second, end_us + 50_000);
    let mut seen = vec![];
    for ms in 1..20_000 {
        let progress = motion.advance(ms * 1000);
        if seen.last() != Some(&progress) {
            seen.push(progress);
        }
    }
    let (run, idle) = (Progress::Running, Progress::Idle);
    assert_eq!(seen, [run, idle, run, idle]);
    assert_eq!(motion.executing(), 13);
}

#[test]
fn an_empty_queue_while_moving_is_an_underrun_and_the_stop_goes_on_from_there() {
    let mut motion = Motion::default();
    accept_run(
        &mut motion,
        &[Segment::new(0, 200_400, 1_000_000, 500_000, 1)],
        1_000,
    );
    let mut ms = 0;
    while motion.advance(ms * 1000) != Progress::Underrun {
        ms += 1;
        assert!(ms < 300);
    }
    assert_eq!(ms, 202, "the first tick after the end at 201.4 ms");
    assert!(!motion.reference().at_rest());
    motion.stop(&LIMITS);
    let mut last = *motion.reference();
    while motion.advance({
        ms += 1;
        ms * 1000
    }) == Progress::Stopping
    {
        let now = *motion.reference();
        let change = now.travel.acceleration_micro() - last.travel.acceleration_micro();
        assert!(change.abs() <= 6_001, "jerk of the stop");
        last = now;
        assert!(ms < 2_000);
    }
    assert!(motion.reference().at_rest());
}

#[test]
fn the_queue_holds_at_least_sixty_four_segments_and_then_says_so() {
    let mut motion = Motion::default();
    let dwell = |index| Segment::new(index, 2_000, 0, 0, u8::from(index == 0));
    let mut accepted = 0;
    let refusal = loop {
        match motion.accept(dwell(accepted), Some(10_000), &LIMITS) {
            Ok(()) => accepted += 1,
            Err(refusal) => break refusal,
        }
    };
    assert_eq!((accepted, refusal), (64, Refusal::QueueFull));
    assert_eq!((motion.queued(), motion.free_slots()), (64, 0));
}

/// Accelerates for `ms` under both jerks (um/s^3, urad/s^3).
fn pushes(travel: i32, heading: i32, ms: u32) -> Result<(), Refusal> {
    let segment = Segment::new(0, ms * 1000, travel, heading, 1);
    Motion::default().accept(segment, Some(1_000_000), &LIMITS)
}

#[test]
fn a_wheel_is_not_asked_for_more_than_its_motor_can() {
    // 0.7 s of jerk j end at 0.245 j: 0.30 m/s alone, and with 1.96 rad/s, which is 0.50 m/s at the outer wheel.
    assert_eq!(pushes(1_225_000, 0, 700), Ok(()));
    assert_eq!(pushes(0, 8_000_000, 700), Ok(()));
    for heading in [8_000_000, -8_000_000] {
        assert_eq!(pushes(1_225_000, heading, 700), Err(Refusal::BeyondLimits));
        assert_eq!(pushes(-1_225_000, heading, 700), Err(Refusal::BeyondLimits));
    }
    // 0.44 m/s straight on, and 0.48, which the limit of travel alone would let pass.
    assert_eq!(pushes(1_800_000, 0, 700), Ok(()));
    assert_eq!(pushes(1_960_000, 0, 700), Err(Refusal::BeyondLimits));
}
