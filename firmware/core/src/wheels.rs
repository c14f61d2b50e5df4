//! Wheel control at 1 kHz: feed-forward of the reference, PI on the velocity, and a position term that keeps the
//! travelled way on the reference's. All in 32 bits: positions wrap every 4.3 m, of which only differences count.

use crate::axis::Axis;
use crate::fixed_point::{product, saturated, upper};
use crate::motion::Reference;
use crate::parameters::{Parameter, Parameters};
use crate::velocity_observer::VelocityObserver;

const FULL: i32 = 32_767;
/// Below this the static feed-forward grows linearly, so that it does not jump at a change of direction.
const STATIC_BLEND_UM_S: i32 = 5_000;
/// At rest: less than two counts away and no motion to speak of means no duty, so that nothing hums.
const REST_ERROR_UM: i32 = 200;
const REST_VELOCITY_UM_S: i32 = 6_000;
/// The position term never asks for more than this.
const CORRECTION_LIMIT_UM_S: i32 = 150_000;
/// Beyond this the velocity error counts no more; every sensible gain is saturated long before.
const ERROR_LIMIT_UM_S: i32 = 1_000_000;
/// Duty on its way to the output has 8 bits of fraction, and each part of it stays below this.
const FRACTION_BITS: u32 = 8;
const PART_LIMIT: i64 = 1 << 28;
/// 2^32 / 1000: nm to um by `upper`.
const THOUSANDTH: i32 = 4_294_967;

/// What the parameters say about control, in the units of the arithmetic.
#[derive(Clone, Copy, Debug, Default)]
pub struct Gains {
    /// Per um/s, um/s^2 and um/s; 28 bits of fraction.
    feed_static: i32,
    feed_velocity: i32,
    feed_acceleration: i32,
    velocity: i32,
    /// Per um/s in each tick; 32 bits of fraction.
    integral: i32,
    integral_limit: i64,
    /// 1/s.
    position: i32,
    /// Duty beyond what the reference needs, Q15 with `FRACTION_BITS`.
    margin: i32,
    /// Duty that friction needs at any speed, likewise.
    friction: i32,
    nominal_mv: u32,
    /// A battery below 60 % of nominal is not compensated further: the duty would only saturate.
    least_mv: u32,
}

impl Gains {
    pub fn new(parameters: &Parameters) -> Self {
        let value = |parameter| parameters.value(parameter);
        let per_million = |gain: i64| saturated((gain << 28) / 1_000_000);
        let nominal_mv = value(Parameter::NominalMv).clamp(1, 60_000) as u32;
        let blend = i64::from(STATIC_BLEND_UM_S);
        Self {
            feed_static: saturated((value(Parameter::FeedStatic) << 28) / blend),
            feed_velocity: per_million(value(Parameter::FeedVelocity)),
            feed_acceleration: per_million(value(Parameter::FeedAcceleration)),
            velocity: per_million(value(Parameter::GainVelocity)),
            integral: saturated((value(Parameter::GainIntegral) << 32) / 1_000_000_000),
            integral_limit: value(Parameter::IntegralLimit) << 32,
            position: saturated(value(Parameter::GainPosition)),
            margin: saturated(value(Parameter::DutyMargin) << FRACTION_BITS),
            friction: saturated(value(Parameter::FeedStatic) << FRACTION_BITS),
            nominal_mv,
            least_mv: (nominal_mv * 3 / 5).max(1),
        }
    }

    /// Nominal over measured voltage, 16 bits of fraction: at most 5/3.
    pub fn battery_scale(&self, battery_mv: u16) -> i32 {
        let battery_mv = u32::from(battery_mv).max(self.least_mv);
        (self.nominal_mv << 16).checked_div(battery_mv).unwrap_or(0) as i32
    }
}

/// What one wheel should do now.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WheelReference {
    /// nm since boot, wrapping.
    pub position_nm: i32,
    /// um/s.
    pub velocity: i32,
    /// um/s^2.
    pub acceleration: i32,
}

/// Half the distance between the wheels: turns a heading into the way of a wheel.
#[derive(Clone, Copy, Debug, Default)]
pub struct HalfTrack {
    /// nm of way for a whole radian.
    whole_nm: i32,
    /// The same as a factor, 31 bits of fraction.
    factor: i32,
}

impl HalfTrack {
    pub fn new(track_um: i64) -> Self {
        Self {
            whole_nm: saturated(track_um * 500),
            factor: saturated((track_um << 31) / 2_000_000),
        }
    }

    fn of(&self, micro: i32) -> i32 {
        (product(micro, self.factor) >> 31) as i32
    }

    fn way_nm(&self, heading: &Axis) -> i32 {
        let (whole, nano) = heading.whole_and_nano();
        whole
            .wrapping_mul(self.whole_nm)
            .wrapping_add(self.of(nano))
    }
}

/// Split a motion of the body between the wheels: left = travel - heading * track / 2. Returns left, right.
pub fn wheel_references(reference: &Reference, half_track: &HalfTrack) -> [WheelReference; 2] {
    let (travel, heading) = (&reference.travel, &reference.heading);
    let (whole, nano) = travel.whole_and_nano();
    let position_nm = whole.wrapping_mul(1_000_000_000).wrapping_add(nano);
    let (velocity, acceleration) = (travel.quick_velocity(), travel.quick_acceleration());
    let turn_nm = half_track.way_nm(heading);
    let turn_velocity = half_track.of(heading.quick_velocity());
    let turn_acceleration = half_track.of(heading.quick_acceleration());
    [
        WheelReference {
            position_nm: position_nm.wrapping_sub(turn_nm),
            velocity: velocity.saturating_sub(turn_velocity),
            acceleration: acceleration.saturating_sub(turn_acceleration),
        },
        WheelReference {
            position_nm: position_nm.wrapping_add(turn_nm),
            velocity: velocity.saturating_add(turn_velocity),
            acceleration: acceleration.saturating_add(turn_acceleration),
        },
    ]
}

/// Control of one wheel.
#[derive(Clone, Debug, Default)]
pub struct Wheel {
    observer: VelocityObserver,
    measured_nm: i32,
    /// Measured minus reference position at the last reset.
    offset_nm: i32,
    /// Q15 with 32 bits of fraction.
    integral: i64,
    error_um: i32,
    duty: i16,
    /// The duty is at its bound.
    strained: bool,
}

impl Wheel {
    /// Take the measured position in nm since boot, wrapping. Call every tick, also while the motors are off.
    pub fn measure(&mut self, position_nm: i32) {
        self.measured_nm = position_nm;
        self.observer.update(position_nm);
    }

    /// The reference is where the wheel stands, whatever was before.
    pub fn reset(&mut self, reference: &WheelReference) {
        self.offset_nm = self.measured_nm.wrapping_sub(reference.position_nm);
        self.release();
    }

    pub fn velocity_um_s(&self) -> i32 {
        self.observer.velocity_um_s()
    }

    /// How far the wheel is behind its reference, um.
    pub fn following_error_um(&self) -> i32 {
        self.error_um
    }

    pub fn duty(&self) -> i16 {
        self.duty
    }

    /// The duty has reached the most that the commanded motion can need.
    pub fn is_strained(&self) -> bool {
        self.strained
    }

    /// Duty for this tick, Q15; `battery_scale` is that of [`Gains::battery_scale`].
    pub fn control(&mut self, reference: &WheelReference, gains: &Gains, battery_scale: i32) {
        let measured = self.observer.velocity_um_s();
        let behind_nm = reference
            .position_nm
            .wrapping_add(self.offset_nm)
            .wrapping_sub(self.measured_nm);
        self.error_um = upper(behind_nm, THOUSANDTH);
        let standing = reference.velocity == 0 && reference.acceleration == 0;
        if standing && self.error_um.abs() <= REST_ERROR_UM && measured.abs() <= REST_VELOCITY_UM_S
        {
            self.integral -= self.integral >> 4;
            self.duty = 0;
            self.strained = false;
            return;
        }
        // At most 2^31 nm behind, so 100 times that in um fits.
        let correction = (gains.position * self.error_um.clamp(-1_000_000, 1_000_000))
            .clamp(-CORRECTION_LIMIT_UM_S, CORRECTION_LIMIT_UM_S);
        let error = reference
            .velocity
            .saturating_add(correction)
            .saturating_sub(measured)
            .clamp(-ERROR_LIMIT_UM_S, ERROR_LIMIT_UM_S);
        let speed = part(gains.feed_velocity, reference.velocity);
        let push = part(gains.feed_acceleration, reference.acceleration);
        let wanted = part(gains.feed_static, blend(reference.velocity))
            + speed
            + push
            + part(gains.velocity, error)
            + (self.integral >> (32 - FRACTION_BITS)) as i32;
        // A wheel whose encoder is silent gets no more than this, so the rover does not run away at a slow command.
        let bound = gains
            .friction
            .saturating_add(gains.margin)
            .saturating_add(speed.abs())
            .saturating_add(push.abs());
        self.strained = wanted.abs() >= bound;
        let bounded = wanted.min(bound).max(-bound);
        let duty = saturated(product(bounded, battery_scale) >> (16 + FRACTION_BITS));
        // Anti-windup: a saturated output only lets the integral come back.
        let full = self.strained || duty.abs() > FULL;
        if !(full && (wanted < 0) == (error < 0)) {
            // Not clamp: it panics when its bounds are the wrong way round.
            let integral = self.integral + product(gains.integral, error);
            self.integral = integral
                .min(gains.integral_limit)
                .max(-gains.integral_limit);
        }
        self.duty = duty.clamp(-FULL, FULL) as i16;
    }

    /// The motors are off.
    pub fn release(&mut self) {
        self.integral = 0;
        self.error_um = 0;
        self.duty = 0;
        self.strained = false;
    }
}

/// One part of the duty: a gain with 28 bits of fraction times a value. Five of them cannot overflow together.
fn part(gain: i32, value: i32) -> i32 {
    let part = product(gain, value) >> (28 - FRACTION_BITS);
    part.clamp(-PART_LIMIT, PART_LIMIT) as i32
}

/// Sign of a velocity, linear near zero; in units of `STATIC_BLEND_UM_S`.
fn blend(velocity: i32) -> i32 {
    velocity.clamp(-STATIC_BLEND_UM_S, STATIC_BLEND_UM_S)
}
