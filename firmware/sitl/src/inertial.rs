//! The board's inertial sensor as firmware/pico/src/inertial.rs asks it: every 4 ms, answered at the next tick; looked for
//! at every tenth of a second while it does not answer.

use rover_core::InertialSample;
use rover_protocol::rig_tick::TickRequest;

const SAMPLE_US: u64 = 4_000;
const LOOK_US: u64 = 100_000;
const FAILURES: u32 = 5;
/// `TickRequest.inertial` of one that answers.
const ANSWERS: u8 = 1;

/// What stands between the sensor and the core.
#[derive(Default)]
pub struct Inertial {
    /// None while nobody has answered.
    failures: Option<u32>,
    /// Of the last tick's question.
    answer: Option<InertialSample>,
}

impl Inertial {
    /// What the core gets at a tick.
    pub fn measure(&mut self, request: &TickRequest) -> Option<InertialSample> {
        let answer = self.answer.take();
        if request.now_us.is_multiple_of(SAMPLE_US) {
            self.ask(request);
        }
        answer
    }

    fn ask(&mut self, request: &TickRequest) {
        let answers = request.inertial == ANSWERS;
        match &mut self.failures {
            None if answers && request.now_us.is_multiple_of(LOOK_US) => self.failures = Some(0),
            None => {}
            Some(failures) if answers => {
                *failures = 0;
                self.answer = Some(sample(request));
            }
            Some(failures) => {
                *failures += 1;
                if *failures >= FAILURES {
                    self.failures = None;
                }
            }
        }
    }
}

fn sample(request: &TickRequest) -> InertialSample {
    InertialSample {
        gyro: [request.gyro_x, request.gyro_y, request.gyro_z],
        acceleration: [
            request.acceleration_x,
            request.acceleration_y,
            request.acceleration_z,
        ],
        temperature: request.temperature,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answers(from_ms: u64, to_ms: u64, inertial: &mut Inertial, state: u8) -> usize {
        (from_ms..to_ms)
            .filter(|ms| {
                let mut request = TickRequest::read(&[0; TickRequest::SIZE]);
                request.now_us = ms * 1_000;
                request.inertial = state;
                inertial.measure(&request).is_some()
            })
            .count()
    }

    #[test]
    fn it_is_asked_250_times_a_second_from_the_tenth_of_a_second_at_which_it_is_found() {
        let mut inertial = Inertial::default();
        assert_eq!(answers(1, 105, &mut inertial, 1), 0);
        assert_eq!(answers(105, 1_105, &mut inertial, 1), 250);
    }

    #[test]
    fn one_that_was_lost_is_looked_for_again() {
        let mut inertial = Inertial::default();
        answers(1, 202, &mut inertial, 1);
        assert_eq!(answers(202, 350, &mut inertial, 0), 0);
        assert_eq!(answers(350, 405, &mut inertial, 1), 0);
        assert!(answers(405, 500, &mut inertial, 1) > 20);
    }
}
