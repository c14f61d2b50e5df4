//! Every number that may differ from one rover to the next: identifier, default, range.

/// A parameter's identifier on the wire is its discriminant. Never reuse one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u16)]
pub enum Parameter {
    DeadManMs = 1,
    LowVoltageMv = 2,
    LowVoltageMs = 3,
    TrackUm = 10,
    CountLeftPm = 11,
    CountRightPm = 12,
    StopTravelAcceleration = 20,
    StopTravelJerk = 21,
    StopHeadingAcceleration = 22,
    StopHeadingJerk = 23,
    MaxTravelVelocity = 30,
    MaxTravelAcceleration = 31,
    MaxHeadingVelocity = 32,
    MaxHeadingAcceleration = 33,
    FeedStatic = 40,
    FeedVelocity = 41,
    FeedAcceleration = 42,
    GainVelocity = 43,
    GainIntegral = 44,
    GainPosition = 45,
    NominalMv = 46,
    IntegralLimit = 47,
    GuardCentreMm = 50,
    GuardSideMm = 51,
    GuardSidePercent = 52,
    GuardLatencyMs = 53,
    GuardEnabled = 54,
    SonarSlotMs = 55,
    SoundSpeed = 56,
    SonarsFitted = 57,
    DutyMargin = 58,
    StallDuty = 60,
    StallVelocity = 61,
    StallMs = 62,
    FollowingErrorUm = 63,
}

/// Name, unit, default and range of one parameter.
#[derive(Clone, Copy, Debug)]
pub struct Definition {
    pub parameter: Parameter,
    pub name: &'static str,
    pub unit: &'static str,
    pub default: i32,
    pub minimum: i32,
    pub maximum: i32,
}

const fn define(
    parameter: Parameter,
    name: &'static str,
    unit: &'static str,
    [default, minimum, maximum]: [i32; 3],
) -> Definition {
    Definition {
        parameter,
        name,
        unit,
        default,
        minimum,
        maximum,
    }
}

pub const COUNT: usize = 35;

/// In the order of the identifiers. Q15: 32767 is full duty.
#[rustfmt::skip]
pub const DEFINITIONS: [Definition; COUNT] = [
    define(Parameter::DeadManMs, "dead_man", "ms", [300, 50, 5_000]),
    define(Parameter::LowVoltageMv, "low_voltage", "mV", [6_200, 0, 60_000]),
    define(Parameter::LowVoltageMs, "low_voltage_delay", "ms", [500, 10, 10_000]),
    define(Parameter::TrackUm, "track", "um", [200_000, 50_000, 1_000_000]),
    // 2 pi 0.0325 m / 1560 counts.
    define(Parameter::CountLeftPm, "count_left", "pm", [130_899_694, 1_000_000, 2_000_000_000]),
    define(Parameter::CountRightPm, "count_right", "pm", [130_899_694, 1_000_000, 2_000_000_000]),
    define(Parameter::StopTravelAcceleration, "stop_travel_acceleration", "um/s^2", [800_000, 50_000, 5_000_000]),
    define(Parameter::StopTravelJerk, "stop_travel_jerk", "um/s^3", [6_000_000, 100_000, 100_000_000]),
    define(Parameter::StopHeadingAcceleration, "stop_heading_acceleration", "urad/s^2", [4_000_000, 100_000, 20_000_000]),
    define(Parameter::StopHeadingJerk, "stop_heading_jerk", "urad/s^3", [8_000_000, 100_000, 100_000_000]),
    define(Parameter::MaxTravelVelocity, "max_travel_velocity", "um/s", [500_000, 1_000, 2_000_000]),
    define(Parameter::MaxTravelAcceleration, "max_travel_acceleration", "um/s^2", [1_500_000, 1_000, 20_000_000]),
    define(Parameter::MaxHeadingVelocity, "max_heading_velocity", "urad/s", [2_500_000, 1_000, 4_000_000]),
    define(Parameter::MaxHeadingAcceleration, "max_heading_acceleration", "urad/s^2", [8_000_000, 1_000, 50_000_000]),
    // Between a stiff motor (10 % of duty for friction, 60 ms) and a brisk one (3 %, 22 ms), both 0.45 m/s at full duty.
    define(Parameter::FeedStatic, "feed_static", "Q15", [2_000, 0, 16_384]),
    define(Parameter::FeedVelocity, "feed_velocity", "Q15 per m/s", [68_000, 0, 1_000_000]),
    define(Parameter::FeedAcceleration, "feed_acceleration", "Q15 per m/s^2", [2_600, 0, 1_000_000]),
    define(Parameter::GainVelocity, "gain_velocity", "Q15 per m/s", [120_000, 0, 2_000_000]),
    define(Parameter::GainIntegral, "gain_integral", "Q15 per m", [1_200_000, 0, 20_000_000]),
    define(Parameter::GainPosition, "gain_position", "1/s", [10, 0, 100]),
    define(Parameter::NominalMv, "nominal_voltage", "mV", [7_400, 1_000, 60_000]),
    define(Parameter::IntegralLimit, "integral_limit", "Q15", [16_384, 0, 32_767]),
    define(Parameter::GuardCentreMm, "guard_centre", "mm", [60, 0, 4_000]),
    define(Parameter::GuardSideMm, "guard_side", "mm", [100, 0, 4_000]),
    define(Parameter::GuardSidePercent, "guard_side_share", "%", [50, 0, 100]),
    define(Parameter::GuardLatencyMs, "guard_latency", "ms", [130, 0, 1_000]),
    define(Parameter::GuardEnabled, "guard_enabled", "0 or 1", [1, 0, 1]),
    define(Parameter::SonarSlotMs, "sonar_slot", "ms", [33, 25, 500]),
    define(Parameter::SoundSpeed, "sound_speed", "mm/s", [343_000, 300_000, 380_000]),
    // A bit for each sensor that the rover has: 1 left, 2 centre, 4 right.
    define(Parameter::SonarsFitted, "sonars_fitted", "bits", [7, 0, 7]),
    // Beyond what the commanded speed needs by the feed-forward: a slope of 25 degrees.
    define(Parameter::DutyMargin, "duty_margin", "Q15", [5_000, 1_000, 32_767]),
    define(Parameter::StallDuty, "stall_duty", "Q15", [19_660, 1, 32_767]),
    define(Parameter::StallVelocity, "stall_velocity", "um/s", [10_000, 1, 1_000_000]),
    define(Parameter::StallMs, "stall_time", "ms", [400, 10, 10_000]),
    define(Parameter::FollowingErrorUm, "following_error", "um", [40_000, 1_000, 1_000_000]),
];

/// Where in the table each identifier is, so that no search is needed.
const PLACES: [u8; 64] = {
    let mut places = [0; 64];
    let mut rest: &[Definition] = &DEFINITIONS;
    let mut place = 0;
    while let [definition, tail @ ..] = rest {
        let identifier = definition.parameter as usize;
        // Not indexed: a constant expression, checked by the compiler.
        #[allow(clippy::indexing_slicing)]
        {
            places[identifier] = place;
        }
        place += 1;
        rest = tail;
    }
    places
};

/// Why a parameter could not be read or set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParameterError {
    Unknown,
    OutOfRange,
}

/// The values in memory.
#[derive(Clone, Debug)]
pub struct Parameters {
    values: [i32; COUNT],
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            values: DEFINITIONS.map(|definition| definition.default),
        }
    }
}

impl Parameters {
    pub fn value(&self, parameter: Parameter) -> i64 {
        let place = PLACES.get(parameter as usize).copied().unwrap_or(0);
        self.values
            .get(usize::from(place))
            .copied()
            .map_or(0, i64::from)
    }

    /// Value by the identifier on the wire.
    pub fn get(&self, identifier: u16) -> Result<i32, ParameterError> {
        let (at, _) = find(identifier)?;
        self.values.get(at).copied().ok_or(ParameterError::Unknown)
    }

    pub fn set(&mut self, identifier: u16, value: i32) -> Result<(), ParameterError> {
        let (at, definition) = find(identifier)?;
        if !(definition.minimum..=definition.maximum).contains(&value) {
            return Err(ParameterError::OutOfRange);
        }
        let slot = self.values.get_mut(at).ok_or(ParameterError::Unknown)?;
        *slot = value;
        Ok(())
    }
}

fn find(identifier: u16) -> Result<(usize, &'static Definition), ParameterError> {
    DEFINITIONS
        .iter()
        .enumerate()
        .find(|(_, definition)| definition.parameter as u16 == identifier)
        .ok_or(ParameterError::Unknown)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn identifiers_rise_and_defaults_are_in_range() {
        for pair in DEFINITIONS.windows(2) {
            assert!((pair[0].parameter as u16) < pair[1].parameter as u16);
        }
        for d in DEFINITIONS {
            assert!(
                d.minimum <= d.default && d.default <= d.maximum,
                "{}",
                d.name
            );
        }
    }

    #[test]
    fn each_value_is_that_of_its_own_identifier() {
        let parameters = Parameters::default();
        for definition in DEFINITIONS {
            let value = parameters.value(definition.parameter);
            assert_eq!(value, i64::from(definition.default));
        }
    }

    #[test]
    fn a_value_out_of_range_or_unknown_changes_nothing() {
        let mut parameters = Parameters::default();
        assert_eq!(parameters.set(1, 49), Err(ParameterError::OutOfRange));
        assert_eq!(parameters.get(1), Ok(300));
        assert_eq!(parameters.set(1, 50), Ok(()));
        assert_eq!(parameters.get(1), Ok(50));
        assert_eq!(parameters.set(999, 1), Err(ParameterError::Unknown));
        assert_eq!(parameters.get(999), Err(ParameterError::Unknown));
    }
}
