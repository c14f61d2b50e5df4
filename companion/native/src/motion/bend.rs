//! A bend as constant-jerk segments: three of equal time from node to node.
//!
//! Every curve starts from the pose and the state in which the quantised segments so far really end: its length makes up
//! for what is missing along the path, its angle leads back to it. Rounding does not add up.

use super::limits::Limits;

/// The shortest segment, µs.
const MIN_DURATION_US: i64 = 1_000;
/// Metres ahead at which what is missing beside the path is made up for, at least, and the most that this may turn by.
const MIN_AIM_M: f64 = 0.3;
const MAX_AIM_RAD: f64 = 5e-3;
/// A segment that turns by more is integrated in parts.
const MAX_STEP_RAD: f64 = 0.4;

/// Pose and derivatives of travel and heading (SI).
#[derive(Clone, Copy, Debug, Default)]
pub struct State {
    /// Metres.
    pub x: f64,
    /// Metres.
    pub y: f64,
    /// Radians.
    pub heading: f64,
    /// m/s.
    pub speed: f64,
    /// m/s².
    pub acceleration: f64,
    /// rad/s.
    pub turn_rate: f64,
    /// rad/s².
    pub turn_acceleration: f64,
}

/// One curve between two nodes: where it begins, how long it is, what it turns by; speed, acceleration, curvature and its
/// slope at its end; `ahead`: length of the piece behind it.
#[derive(Clone, Copy, Debug)]
pub struct Curve {
    /// Metres.
    pub x: f64,
    /// Metres.
    pub y: f64,
    /// Radians.
    pub heading: f64,
    /// Metres.
    pub length: f64,
    /// Radians.
    pub angle: f64,
    /// m/s.
    pub speed: f64,
    /// m/s².
    pub acceleration: f64,
    /// 1/m.
    pub curvature: f64,
    /// 1/m².
    pub slope: f64,
    /// Metres.
    pub ahead: f64,
}

/// Duration in µs and jerks in millionths of the SI unit.
pub type Segment = [i64; 3];

/// The three segments of a curve, from the state, which they move.
pub fn drive(state: &mut State, curve: &Curve, limits: &Limits) -> [Segment; 3] {
    let (sine, cosine) = curve.heading.sin_cos();
    let missing = (curve.x - state.x) * cosine + (curve.y - state.y) * sine;
    let distance = (curve.length + missing).max(0.5 * curve.length);
    let end_heading = curve.heading + curve.angle;
    let (sine, cosine) = end_heading.sin_cos();
    let beside = (state.y - curve.y) * cosine - (state.x - curve.x) * sine;
    let aim = (-beside / curve.ahead.max(MIN_AIM_M)).clamp(-MAX_AIM_RAD, MAX_AIM_RAD);
    let angle = wrapped(end_heading + aim - state.heading);
    let third_us =
        ((duration(state, distance, curve) * 1e6 / 3.0).round() as i64).max(MIN_DURATION_US);
    let time = 3e-6 * third_us as f64;
    let way = time * (state.speed + curve.speed) / 2.0
        + time * time * (state.acceleration - curve.acceleration) / 12.0;
    let third = 1e-6 * third_us as f64;
    let travel = jerks_to(
        [state.speed, state.acceleration],
        [curve.speed, curve.acceleration],
        [way, distance],
        third,
        limits.travel.jerk,
    );
    let turning = jerks_to(
        [state.turn_rate, state.turn_acceleration],
        [
            curve.curvature * curve.speed,
            curve.slope * curve.speed * curve.speed + curve.curvature * curve.acceleration,
        ],
        [curve.angle, angle],
        third,
        limits.heading.jerk,
    );
    std::array::from_fn(|part| {
        let segment = [third_us, travel[part], turning[part]];
        advance(state, &segment);
        segment
    })
}

fn wrapped(angle: f64) -> f64 {
    angle - std::f64::consts::TAU * (angle / std::f64::consts::TAU).round()
}

/// Seconds in which a quintic would lead over the distance: T (v₀ + v₁) / 2 + T² (a₀ − a₁) / 12.
fn duration(state: &State, distance: f64, curve: &Curve) -> f64 {
    let speeds = state.speed + curve.speed;
    let change = (state.acceleration - curve.acceleration) / 12.0;
    let mut time = 2.0 * distance / speeds.max(1e-6);
    for _ in 0..3 {
        time = distance / (speeds / 2.0 + time * change).max(0.2 * speeds).max(1e-6);
    }
    time
}

/// Jerks in millionths of the SI unit in three equal times of `t` seconds that lead from one speed and acceleration to
/// another. They cover a way between the two given: as near to the second as no jerk above `most` allows, and the first
/// when that needs more itself.
fn jerks_to(begin: [f64; 2], end: [f64; 2], ways: [f64; 2], t: f64, most: f64) -> [i64; 3] {
    let ([v0, a0], [v1, a1]) = (begin, end);
    // The sums of 1, 1, 1; of 5/2, 3/2, 1/2 and of 19/6, 7/6, 1/6 times the jerks, for acceleration, speed and way.
    let a = (a1 - a0) / t;
    let b = (v1 - v0 - 3.0 * t * a0) / (t * t);
    let c = (ways[0] - 3.0 * t * v0 - 4.5 * t * t * a0) / (t * t * t);
    let first = c + a / 3.0 - b;
    let second = b - 0.5 * a - 2.0 * first;
    let jerks = [first, second, a - first - second];
    let mut more = (ways[1] - ways[0]) / (t * t * t);
    for (jerk, times) in jerks.iter().zip([1.0, -2.0, 1.0]) {
        let step: f64 = times * more;
        if step != 0.0 && (jerk + step).abs() > most {
            more *= ((most - jerk.abs()) / step.abs()).max(0.0);
        }
    }
    [
        (1e6 * (jerks[0] + more)).round() as i64,
        (1e6 * (jerks[1] - 2.0 * more)).round() as i64,
        (1e6 * (jerks[2] + more)).round() as i64,
    ]
}

/// The state at the end of a segment: exact, but for the position, by three-point Gauss quadrature.
pub fn advance(state: &mut State, segment: &Segment) {
    let t = segment[0] as f64 * 1e-6;
    let (j, i) = (segment[1] as f64 * 1e-6, segment[2] as f64 * 1e-6);
    let (v, a, w, b) = (
        state.speed,
        state.acceleration,
        state.turn_rate,
        state.turn_acceleration,
    );
    let turned = t * (w + t * (b / 2.0 + t * i / 6.0));
    let parts = 1 + ((turned.abs() + t * w.abs()) / MAX_STEP_RAD) as usize;
    let step = t / parts as f64;
    let off = 0.15_f64.sqrt();
    for part in 0..parts {
        for (node, weight) in [
            (0.5 - off, 5.0 / 18.0),
            (0.5, 8.0 / 18.0),
            (0.5 + off, 5.0 / 18.0),
        ] {
            let r = (part as f64 + node) * step;
            let way = weight * step * (v + r * (a + r * j / 2.0));
            let (sine, cosine) = (state.heading + r * (w + r * (b / 2.0 + r * i / 6.0))).sin_cos();
            state.x += way * cosine;
            state.y += way * sine;
        }
    }
    state.heading += turned;
    state.speed = v + t * (a + t * j / 2.0);
    state.acceleration = a + t * j;
    state.turn_rate = w + t * (b + t * i / 2.0);
    state.turn_acceleration = b + t * i;
}
