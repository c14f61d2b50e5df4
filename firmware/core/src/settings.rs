//! The parameters as the control loop needs them: worked out when one of them changes, not a thousand times a second.

use crate::axis::Limits;
use crate::guard::Guard;
use crate::motion::MotionLimits;
use crate::odometry::WheelGeometry;
use crate::parameters::{Parameter, Parameters};
use crate::wheels::{Gains, HalfTrack};
use crate::wiring::Wiring;

#[derive(Clone, Debug)]
pub struct Settings {
    pub dead_man_us: u64,
    pub low_voltage_mv: i32,
    pub low_voltage_delay_us: u64,
    pub geometry: WheelGeometry,
    pub half_track: HalfTrack,
    pub gains: Gains,
    pub guard: Guard,
    pub stall: Stall,
    pub sonar_slot_us: u64,
    pub sound_speed: i64,
    /// A bit for each sonar whose loss counts: those that the rover has, none while nobody listens to them.
    pub sonars_needed: u8,
    pub motion: MotionLimits,
    pub wiring: Wiring,
}

/// When a wheel does not follow.
#[derive(Clone, Copy, Debug)]
pub struct Stall {
    /// Q15.
    pub duty: i32,
    /// um/s.
    pub velocity: i32,
    pub ticks: u32,
    pub following_error_um: i32,
}

impl Settings {
    pub fn new(parameters: &Parameters) -> Self {
        let value = |parameter| parameters.value(parameter);
        let milliseconds = |parameter| value(parameter).unsigned_abs() * 1000;
        Self {
            dead_man_us: milliseconds(Parameter::DeadManMs),
            low_voltage_mv: value(Parameter::LowVoltageMv) as i32,
            low_voltage_delay_us: milliseconds(Parameter::LowVoltageMs),
            geometry: WheelGeometry::new(
                [
                    value(Parameter::CountLeftPm),
                    value(Parameter::CountRightPm),
                ],
                value(Parameter::TrackUm),
            ),
            half_track: HalfTrack::new(value(Parameter::TrackUm)),
            gains: Gains::new(parameters),
            guard: Guard::new(parameters),
            stall: Stall {
                duty: value(Parameter::StallDuty) as i32,
                velocity: value(Parameter::StallVelocity) as i32,
                ticks: value(Parameter::StallMs) as u32,
                following_error_um: value(Parameter::FollowingErrorUm) as i32,
            },
            sonar_slot_us: milliseconds(Parameter::SonarSlotMs),
            sound_speed: value(Parameter::SoundSpeed),
            sonars_needed: match value(Parameter::GuardEnabled) {
                0 => 0,
                _ => value(Parameter::SonarsFitted) as u8,
            },
            wiring: Wiring::new(parameters),
            motion: MotionLimits {
                travel: Limits {
                    velocity: value(Parameter::MaxTravelVelocity),
                    acceleration: value(Parameter::MaxTravelAcceleration),
                },
                heading: Limits {
                    velocity: value(Parameter::MaxHeadingVelocity),
                    acceleration: value(Parameter::MaxHeadingAcceleration),
                },
                stop_travel: (
                    value(Parameter::StopTravelAcceleration),
                    value(Parameter::StopTravelJerk),
                ),
                stop_heading: (
                    value(Parameter::StopHeadingAcceleration),
                    value(Parameter::StopHeadingJerk),
                ),
                wheel: wheel_speed(parameters),
                half_track_um: value(Parameter::TrackUm) / 2,
            },
        }
    }
}

/// What a wheel reaches with full duty by the feed-forward, um/s; without one nobody knows, and nothing is held back.
fn wheel_speed(parameters: &Parameters) -> i64 {
    const FULL: i64 = 32_767;
    let left = FULL - parameters.value(Parameter::FeedStatic);
    (left * 1_000_000)
        .checked_div(parameters.value(Parameter::FeedVelocity))
        .unwrap_or(i64::MAX)
}
