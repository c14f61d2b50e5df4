//! The sonar guard: stop before what the sensors see, at a distance that grows with speed.

use crate::parameters::{Parameter, Parameters};
use crate::sonar::{Sonar, NO_ECHO_MM};

/// The guard's parameters.
#[derive(Clone, Copy, Debug, Default)]
pub struct Guard {
    enabled: bool,
    /// um/s^2 and um/s^3.
    acceleration: i64,
    jerk: i64,
    latency_ms: i64,
    centre_mm: i64,
    side_mm: i64,
    side_percent: i64,
    /// No sensor can trip the guard from further away, at any speed up to `fastest`.
    reach_mm: u16,
    fastest: i64,
}

impl Guard {
    pub fn new(parameters: &Parameters) -> Self {
        let value = |parameter| parameters.value(parameter);
        let mut guard = Self {
            enabled: value(Parameter::GuardEnabled) != 0,
            acceleration: value(Parameter::StopTravelAcceleration).max(1),
            jerk: value(Parameter::StopTravelJerk).max(1),
            latency_ms: value(Parameter::GuardLatencyMs),
            centre_mm: value(Parameter::GuardCentreMm),
            side_mm: value(Parameter::GuardSideMm),
            side_percent: value(Parameter::GuardSidePercent),
            reach_mm: 0,
            fastest: value(Parameter::MaxTravelVelocity),
        };
        let (centre, side) = guard.bounds_mm(guard.fastest);
        guard.reach_mm = centre.max(side).clamp(0, i64::from(NO_ECHO_MM)) as u16;
        guard
    }

    /// Way in mm from the moment that an obstacle comes into range until the rover stands: the sensors' and filter's
    /// latency at full speed, then a jerk-limited stop, v^2/2a + va/2j (exact when the deceleration reaches its limit,
    /// longer than the truth when it does not).
    pub fn stop_distance_mm(&self, velocity_um_s: i64) -> i64 {
        let v = velocity_um_s.clamp(0, 5_000_000);
        let (a, j) = (self.acceleration, self.jerk);
        let braking = quotient(v * v, a) / 2 + quotient(v * a, j) / 2;
        let latency = v * self.latency_ms / 1000;
        (braking + latency) / 1000
    }

    /// Nearest range of the centre and of the side sensors at which the rover may go on at this speed.
    fn bounds_mm(&self, velocity_um_s: i64) -> (i64, i64) {
        let stop = self.stop_distance_mm(velocity_um_s);
        let side = self.side_mm + stop * self.side_percent / 100;
        (stop + self.centre_mm, side)
    }

    /// The sensor that sees something too near for the speed, if any. Only forward travel is guarded: the sensors look
    /// ahead, and turning on the spot stays inside the footprint.
    pub fn too_near(&self, sonar: &Sonar, velocity_um_s: i64) -> Option<u8> {
        if velocity_um_s <= 0 || !self.enabled {
            return None;
        }
        // The bounds grow with speed, so this answers nearly always, and without a division.
        if velocity_um_s <= self.fastest && sonar.nearest_mm() >= self.reach_mm {
            return None;
        }
        let (centre, side) = self.bounds_mm(velocity_um_s);
        // The centre first: it is what the rover would hit.
        [(1_u8, centre), (0, side), (2, side)]
            .iter()
            .find(|(sensor, bound)| {
                let range = sonar.range_mm(usize::from(*sensor));
                range != NO_ECHO_MM && i64::from(range) < *bound
            })
            .map(|(sensor, _)| *sensor)
    }
}

fn quotient(numerator: i64, denominator: i64) -> i64 {
    numerator.checked_div(denominator).unwrap_or(0)
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
        let guard = Guard::new(&Parameters::default());
        assert_eq!(guard.stop_distance_mm(0), 0);
        // 39 mm + 17 mm of braking and 32 mm in 130 ms.
        assert_eq!(guard.stop_distance_mm(250_000), 88);
        assert!(guard.stop_distance_mm(450_000) > 2 * guard.stop_distance_mm(250_000) * 9 / 10);
    }

    #[test]
    fn something_ahead_trips_the_guard_below_the_stop_distance_and_not_above() {
        let guard = Guard::new(&Parameters::default());
        assert_eq!(
            guard.too_near(&seeing([2_000, 145, 2_000]), 250_000),
            Some(1)
        );
        assert_eq!(guard.too_near(&seeing([2_000, 155, 2_000]), 250_000), None);
        assert_eq!(guard.too_near(&seeing([2_000, 145, 2_000]), 100_000), None);
    }

    #[test]
    fn a_rock_passed_at_eight_centimetres_does_not_trip_the_side_sensors() {
        // Nearest in the side cone (edge ray at 45 degrees, sensor 6 cm off the middle): (0.23 - 0.06) / sin 45 = 240.
        let guard = Guard::new(&Parameters::default());
        assert_eq!(guard.too_near(&seeing([240, 2_000, 240]), 250_000), None);
        assert_eq!(
            guard.too_near(&seeing([130, 2_000, 2_000]), 250_000),
            Some(0)
        );
        assert_eq!(
            guard.too_near(&seeing([2_000, 2_000, 130]), 250_000),
            Some(2)
        );
    }

    #[test]
    fn standing_turning_and_backing_are_not_guarded() {
        let guard = Guard::new(&Parameters::default());
        assert_eq!(guard.too_near(&seeing([30, 30, 30]), 0), None);
        assert_eq!(guard.too_near(&seeing([30, 30, 30]), -100_000), None);
    }

    #[test]
    fn what_is_out_of_reach_at_full_speed_is_left_out_and_nothing_else() {
        let guard = Guard::new(&Parameters::default());
        for range in (20..600).step_by(10) {
            let sonar = seeing([2_000, range, 2_000]);
            for velocity in [1, 50_000, 250_000, 499_999, 500_000, 500_001, 900_000] {
                let (centre, _) = guard.bounds_mm(velocity);
                let expected = (i64::from(sonar.range_mm(1)) < centre).then_some(1);
                assert_eq!(
                    guard.too_near(&sonar, velocity),
                    expected,
                    "{range} {velocity}"
                );
            }
        }
    }
}
