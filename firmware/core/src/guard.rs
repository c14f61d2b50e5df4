//! The sonar guard: stop before what the sensors see, at a distance that grows with speed.

use crate::parameters::{Parameter, Parameters};
use crate::sonar::{Sonar, NO_ECHO_MM};

/// Way in mm from the moment that an obstacle comes into range until the rover stands: the sensors' and filter's
/// latency at full speed, then a jerk-limited stop, v^2/2a + va/2j (exact when the deceleration reaches its limit,
/// longer than the truth when it does not).
pub fn stop_distance_mm(velocity_um_s: i64, parameters: &Parameters) -> i64 {
    let v = velocity_um_s.clamp(0, 5_000_000);
    let a = parameters.value(Parameter::StopTravelAcceleration).max(1);
    let j = parameters.value(Parameter::StopTravelJerk).max(1);
    let braking = v * v / a / 2 + v * a / j / 2;
    let latency = v * parameters.value(Parameter::GuardLatencyMs) / 1000;
    (braking + latency) / 1000
}

/// The sensor that sees something too near for the speed, if any. Only forward travel is guarded: the sensors look
/// ahead, and turning on the spot stays inside the footprint.
pub fn too_near(sonar: &Sonar, velocity_um_s: i64, parameters: &Parameters) -> Option<u8> {
    if velocity_um_s <= 0 || parameters.value(Parameter::GuardEnabled) == 0 {
        return None;
    }
    let stop = stop_distance_mm(velocity_um_s, parameters);
    let centre = stop + parameters.value(Parameter::GuardCentreMm);
    let side = parameters.value(Parameter::GuardSideMm)
        + stop * parameters.value(Parameter::GuardSidePercent) / 100;
    // The centre first: it is what the rover would hit.
    [(1_u8, centre), (0, side), (2, side)]
        .iter()
        .find(|(sensor, bound)| {
            let range = sonar.range_mm(usize::from(*sensor));
            range != NO_ECHO_MM && i64::from(range) < *bound
        })
        .map(|(sensor, _)| *sensor)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sonar::SonarEcho;

    /// A sonar whose sensors all have had three equal echoes.
    fn seeing(ranges_mm: [u32; 3]) -> Sonar {
        let mut sonar = Sonar::default();
        let mut echo = None;
        for ms in 0..600 {
            let (trigger, _) = sonar.tick(ms * 1000, echo, 33_000, 343_000);
            echo = trigger.map(|sensor| SonarEcho {
                sensor,
                echo_us: ranges_mm[usize::from(sensor)] * 2_000 / 343 + 6,
            });
        }
        sonar
    }

    #[test]
    fn the_distance_grows_with_speed_and_covers_the_latency() {
        let p = Parameters::default();
        assert_eq!(stop_distance_mm(0, &p), 0);
        // 39 mm + 17 mm of braking and 32 mm in 130 ms.
        assert_eq!(stop_distance_mm(250_000, &p), 88);
        assert!(stop_distance_mm(450_000, &p) > 2 * stop_distance_mm(250_000, &p) * 9 / 10);
    }

    #[test]
    fn something_ahead_trips_the_guard_below_the_stop_distance_and_not_above() {
        let p = Parameters::default();
        assert_eq!(too_near(&seeing([2_000, 145, 2_000]), 250_000, &p), Some(1));
        assert_eq!(too_near(&seeing([2_000, 155, 2_000]), 250_000, &p), None);
        assert_eq!(too_near(&seeing([2_000, 145, 2_000]), 100_000, &p), None);
    }

    #[test]
    fn a_rock_passed_at_eight_centimetres_does_not_trip_the_side_sensors() {
        // Nearest in the side cone (edge ray at 45 degrees, sensor 6 cm off the middle): (0.23 - 0.06) / sin 45 = 240.
        let p = Parameters::default();
        assert_eq!(too_near(&seeing([240, 2_000, 240]), 250_000, &p), None);
        assert_eq!(too_near(&seeing([130, 2_000, 2_000]), 250_000, &p), Some(0));
        assert_eq!(too_near(&seeing([2_000, 2_000, 130]), 250_000, &p), Some(2));
    }

    #[test]
    fn standing_turning_and_backing_are_not_guarded() {
        let p = Parameters::default();
        assert_eq!(too_near(&seeing([30, 30, 30]), 0, &p), None);
        assert_eq!(too_near(&seeing([30, 30, 30]), -100_000, &p), None);
    }
}
