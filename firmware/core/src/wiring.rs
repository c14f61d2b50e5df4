//! What is crossed over or turned round between board and rover, put right: motors, encoders, sonars, divider.
//!
//! Everything else in the core sees the left wheel on the left and forward as positive.

use crate::io::{Inputs, Outputs, SonarEcho};
use crate::parameters::{Parameter, Parameters};

/// For each sensor of the rover, the pins that it hangs on; both in the order left, centre, right.
const ORDERS: [[u8; 3]; 6] = [
    [0, 1, 2],
    [0, 2, 1],
    [1, 0, 2],
    [2, 0, 1],
    [1, 2, 0],
    [2, 1, 0],
];
const UNCHANGED: u64 = 1_000_000;

#[derive(Clone, Copy, Debug)]
pub struct Wiring {
    bits: i64,
    sonars: [u8; 3],
    battery_ppm: u64,
}

impl Wiring {
    pub fn new(parameters: &Parameters) -> Self {
        let order = parameters.value(Parameter::SonarOrder).unsigned_abs() as usize;
        Self {
            bits: parameters.value(Parameter::Wiring),
            sonars: ORDERS.get(order).copied().unwrap_or([0, 1, 2]),
            battery_ppm: parameters.value(Parameter::BatteryScalePpm).unsigned_abs(),
        }
    }

    fn has(&self, bit: i64) -> bool {
        self.bits & bit != 0
    }

    /// The board's measurements as the rover's.
    pub fn inputs(&self, raw: &Inputs) -> Inputs {
        let mut inputs = *raw;
        if self.has(32) {
            (inputs.encoder_left, inputs.encoder_right) = (raw.encoder_right, raw.encoder_left);
        }
        if self.has(4) {
            inputs.encoder_left = inputs.encoder_left.wrapping_neg();
        }
        if self.has(8) {
            inputs.encoder_right = inputs.encoder_right.wrapping_neg();
        }
        if self.battery_ppm != UNCHANGED {
            let scaled = u64::from(raw.battery_mv) * self.battery_ppm / UNCHANGED;
            inputs.battery_mv = u16::try_from(scaled).unwrap_or(u16::MAX);
        }
        inputs.sonar = raw.sonar.map(|echo| SonarEcho {
            sensor: self.sensor_of(echo.sensor),
            ..echo
        });
        inputs
    }

    /// What the rover is to do as what the board is to do.
    pub fn outputs(&self, wanted: Outputs) -> Outputs {
        let mut outputs = wanted;
        if self.has(1) {
            outputs.duty_left = outputs.duty_left.saturating_neg();
        }
        if self.has(2) {
            outputs.duty_right = outputs.duty_right.saturating_neg();
        }
        if self.has(16) {
            (outputs.duty_left, outputs.duty_right) = (outputs.duty_right, outputs.duty_left);
        }
        outputs.sonar_trigger = wanted.sonar_trigger.map(|sensor| {
            let pins = self.sonars.get(usize::from(sensor)).copied();
            pins.unwrap_or(sensor)
        });
        outputs
    }

    fn sensor_of(&self, pins: u8) -> u8 {
        let found = (0..).zip(self.sonars).find(|(_, own)| *own == pins);
        found.map_or(pins, |(sensor, _)| sensor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wired(settings: &[(u16, i32)]) -> Wiring {
        let mut parameters = Parameters::default();
        for (identifier, value) in settings {
            parameters.set(*identifier, *value).unwrap();
        }
        Wiring::new(&parameters)
    }

    const WANTED: Outputs = Outputs {
        duty_left: 100,
        duty_right: -7,
        powered: true,
        sonar_trigger: Some(2),
        led: false,
        buzzer: true,
    };

    #[test]
    fn a_rover_that_is_wired_as_it_should_be_is_left_alone() {
        let raw = Inputs {
            encoder_left: 5,
            encoder_right: i32::MIN,
            battery_mv: 7400,
            ..Inputs::default()
        };
        let seen = wired(&[]).inputs(&raw);
        assert_eq!(
            (seen.encoder_left, seen.encoder_right, seen.battery_mv),
            (5, i32::MIN, 7400)
        );
        assert_eq!(wired(&[]).outputs(WANTED), WANTED);
    }

    #[test]
    fn crossed_and_inverted_wheels_are_the_other_way_round() {
        let raw = Inputs {
            encoder_left: 5,
            encoder_right: -9,
            ..Inputs::default()
        };
        let seen = wired(&[(70, 4 + 32)]).inputs(&raw);
        assert_eq!((seen.encoder_left, seen.encoder_right), (9, 5));
        let done = wired(&[(70, 1 + 16)]).outputs(WANTED);
        assert_eq!((done.duty_left, done.duty_right), (-7, -100));
    }

    #[test]
    fn every_order_of_sonars_answers_for_the_sensor_that_was_asked() {
        for order in 0..6 {
            let wiring = wired(&[(71, order)]);
            for sensor in 0..3 {
                let asked = Outputs {
                    sonar_trigger: Some(sensor),
                    ..WANTED
                };
                let pins = wiring.outputs(asked).sonar_trigger.unwrap();
                let raw = Inputs {
                    sonar: Some(SonarEcho {
                        sensor: pins,
                        echo_us: 1000,
                    }),
                    ..Inputs::default()
                };
                assert_eq!(wiring.inputs(&raw).sonar.unwrap().sensor, sensor);
            }
        }
    }

    #[test]
    fn a_divider_that_reads_low_is_put_right_without_running_over() {
        let raw = |battery_mv| Inputs {
            battery_mv,
            ..Inputs::default()
        };
        let wiring = wired(&[(72, 1_250_000)]);
        assert_eq!(wiring.inputs(&raw(6000)).battery_mv, 7500);
        assert_eq!(wiring.inputs(&raw(u16::MAX)).battery_mv, u16::MAX);
    }
}
