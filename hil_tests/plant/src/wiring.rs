//! Between the board's pins and what is really connected to them.

use crate::config::Wiring;
use crate::drive::Bridge;
use crate::sonar::Echo;

impl Wiring {
    /// What the motors get from the board's bridges.
    pub fn bridge(&self, board: Bridge) -> Bridge {
        let mut bridge = board;
        if self.motors_swapped {
            bridge.duty.swap(0, 1);
        }
        for (duty, inverted) in bridge.duty.iter_mut().zip(self.motors_inverted) {
            *duty = if inverted { -*duty } else { *duty };
        }
        bridge
    }

    /// What the board counts of the wheels' counts.
    pub fn counts(&self, wheels: [i32; 2]) -> [i32; 2] {
        let mut counts = wheels;
        for (wheel, count) in counts.iter_mut().enumerate() {
            if self.encoders_inverted[wheel] {
                *count = count.wrapping_neg();
            }
            if self.encoders_dead[wheel] {
                *count = 0;
            }
        }
        if self.encoders_swapped {
            counts.swap(0, 1);
        }
        counts
    }

    /// The sensor behind the board's pins; None where nothing is connected.
    pub fn sensor(&self, pins: u8) -> Option<u8> {
        let sensor = *self.sonars.get(usize::from(pins))?;
        let dead = self.sonars_dead.get(usize::from(sensor)).copied();
        (dead == Some(false)).then_some(sensor)
    }

    /// The pins on which the board hears a sensor's echo.
    pub fn heard(&self, echo: Echo) -> Echo {
        let found = (0..).zip(self.sonars).find(|(_, own)| *own == echo.sensor);
        Echo {
            sensor: found.map_or(echo.sensor, |(pins, _)| pins),
            ..echo
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn by_default_everything_is_as_it_should_be() {
        let wiring = Wiring::default();
        assert_eq!(wiring.counts([3, -4]), [3, -4]);
        assert_eq!(
            [0, 1, 2].map(|pins| wiring.sensor(pins)),
            [0, 1, 2].map(Some)
        );
        let board = Bridge {
            duty: [0.5, -0.25],
            powered: true,
        };
        assert_eq!(wiring.bridge(board).duty, board.duty);
    }

    #[test]
    fn a_motor_is_swapped_with_its_wires_and_an_encoder_with_its_sign() {
        let wiring = Wiring {
            motors_inverted: [true, false],
            encoders_inverted: [true, false],
            motors_swapped: true,
            encoders_swapped: true,
            ..Wiring::default()
        };
        let board = Bridge {
            duty: [0.5, 0.25],
            powered: true,
        };
        assert_eq!(wiring.bridge(board).duty, [-0.25, 0.5]);
        assert_eq!(wiring.counts([3, -4]), [-4, -3]);
    }

    #[test]
    fn an_echo_comes_back_on_the_pins_that_were_asked() {
        let wiring = Wiring {
            sonars: [1, 2, 0],
            sonars_dead: [true, false, false],
            ..Wiring::default()
        };
        assert_eq!(wiring.sensor(2), None);
        for pins in [0, 1] {
            let sensor = wiring.sensor(pins).unwrap();
            assert_eq!(wiring.heard(Echo { sensor, echo_us: 1 }).sensor, pins);
        }
    }
}
