//! Wheel control at 1 kHz: feed-forward of the reference, PI on the velocity, and a position term that keeps the
//! travelled way on the reference's. Integer arithmetic in um, um/s and Q15 duty.

use crate::motion::Reference;
use crate::parameters::{Parameter, Parameters};
use crate::velocity_observer::VelocityObserver;

const FULL: i64 = 32_767;
/// Below this the static feed-forward grows linearly, so that it does not jump at a change of direction.
const STATIC_BLEND_UM_S: i64 = 5_000;
/// At rest: less than two counts away and no motion to speak of means no duty, so that nothing hums.
const REST_ERROR_UM: i64 = 200;
const REST_VELOCITY_UM_S: i64 = 6_000;
/// The position term never asks for more than this.
const CORRECTION_LIMIT_UM_S: i64 = 150_000;

/// Gains and the battery's scale, read from the parameters once a tick for both wheels.
#[derive(Clone, Copy, Debug)]
pub struct Gains {
    feed_static: i64,
    feed_velocity: i64,
    feed_acceleration: i64,
    velocity: i64,
    integral: i64,
    position: i64,
    integral_limit: i64,
    nominal_mv: i64,
    battery_mv: i64,
}

impl Gains {
    /// A battery below 60 % of nominal is not compensated further: the duty would only saturate.
    pub fn new(parameters: &Parameters, battery_mv: u16) -> Self {
        let nominal_mv = parameters.value(Parameter::NominalMv).max(1);
        Self {
            feed_static: parameters.value(Parameter::FeedStatic),
            feed_velocity: parameters.value(Parameter::FeedVelocity),
            feed_acceleration: parameters.value(Parameter::FeedAcceleration),
            velocity: parameters.value(Parameter::GainVelocity),
            integral: parameters.value(Parameter::GainIntegral),
            position: parameters.value(Parameter::GainPosition),
            integral_limit: parameters.value(Parameter::IntegralLimit) * 1_000_000_000,
            nominal_mv,
            battery_mv: i64::from(battery_mv).max(nominal_mv * 3 / 5).max(1),
        }
    }
}

/// What one wheel should do now.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WheelReference {
    /// nm since boot.
    pub position_nm: i64,
    /// um/s.
    pub velocity: i64,
    /// um/s^2.
    pub acceleration: i64,
}

/// Split a motion of the body between the wheels: left = travel - heading * track / 2. Returns left, right.
pub fn wheel_references(reference: &Reference, track_um: i64) -> [WheelReference; 2] {
    // urad * um = 1e-12 m; halved track and 1e-6.
    let share = |micro: i64| micro.saturating_mul(track_um) / 2_000_000;
    let (travel, heading) = (&reference.travel, &reference.heading);
    let turn = WheelReference {
        position_nm: share(heading.position_nano()),
        velocity: share(heading.velocity_micro()),
        acceleration: share(heading.acceleration_micro()),
    };
    [-1, 1].map(|side| WheelReference {
        position_nm: travel.position_nano() + side * turn.position_nm,
        velocity: travel.velocity_micro() + side * turn.velocity,
        acceleration: travel.acceleration_micro() + side * turn.acceleration,
    })
}

/// Control of one wheel.
#[derive(Clone, Debug, Default)]
pub struct Wheel {
    observer: VelocityObserver,
    measured_nm: i64,
    /// Measured minus reference position at the last reset.
    offset_nm: i64,
    /// Q15 * 1e-9.
    integral: i64,
    error_um: i64,
    duty: i16,
}

impl Wheel {
    /// Take the measured position in nm since boot. Call every tick, also while the motors are off.
    pub fn measure(&mut self, position_nm: i64) {
        self.measured_nm = position_nm;
        self.observer.update(position_nm);
    }

    /// The reference is where the wheel stands, whatever was before.
    pub fn reset(&mut self, reference: &WheelReference) {
        self.offset_nm = self.measured_nm - reference.position_nm;
        self.integral = 0;
        self.error_um = 0;
        self.duty = 0;
    }

    pub fn velocity_um_s(&self) -> i64 {
        self.observer.velocity_um_s()
    }

    /// How far the wheel is behind its reference, um.
    pub fn following_error_um(&self) -> i64 {
        self.error_um
    }

    pub fn duty(&self) -> i16 {
        self.duty
    }

    /// Duty for this tick, Q15.
    pub fn control(&mut self, reference: &WheelReference, gains: &Gains) -> i16 {
        let measured = self.observer.velocity_um_s();
        self.error_um = (reference.position_nm + self.offset_nm - self.measured_nm) / 1000;
        let standing = reference.velocity == 0 && reference.acceleration == 0;
        if standing && self.error_um.abs() <= REST_ERROR_UM && measured.abs() <= REST_VELOCITY_UM_S
        {
            self.integral -= self.integral / 16;
            self.duty = 0;
            return 0;
        }
        let correction = (gains.position * self.error_um.clamp(-1_000_000, 1_000_000))
            .clamp(-CORRECTION_LIMIT_UM_S, CORRECTION_LIMIT_UM_S);
        let error = (reference.velocity + correction - measured).clamp(-5_000_000, 5_000_000);
        // Everything in Q15 * 1e-6 until the one division at the end.
        let feed = gains.feed_static * 1_000_000 * blend(reference.velocity) / STATIC_BLEND_UM_S
            + gains.feed_velocity * reference.velocity
            + gains.feed_acceleration * reference.acceleration;
        let wanted = feed + gains.velocity * error + self.integral / 1000;
        let scaled = wanted / 1_000_000 * gains.nominal_mv;
        let duty = scaled.checked_div(gains.battery_mv).unwrap_or(0);
        // Anti-windup: a saturated output only lets the integral come back.
        let saturated = duty.abs() > FULL && duty.signum() == error.signum();
        if !saturated {
            // Not clamp: it panics when its bounds are the wrong way round.
            let integral = self.integral + gains.integral * error;
            self.integral = integral
                .min(gains.integral_limit)
                .max(-gains.integral_limit);
        }
        self.duty = duty.clamp(-FULL, FULL) as i16;
        self.duty
    }

    /// The motors are off.
    pub fn release(&mut self) {
        self.integral = 0;
        self.error_um = 0;
        self.duty = 0;
    }
}

/// Sign of a velocity, linear near zero; in units of `STATIC_BLEND_UM_S`.
fn blend(velocity: i64) -> i64 {
    velocity.clamp(-STATIC_BLEND_UM_S, STATIC_BLEND_UM_S)
}
