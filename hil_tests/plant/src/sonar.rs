//! Three HC-SR04: the nearest obstacle inside the cone, as the time that the sound takes.

use crate::config;
use crate::faults::SonarFault;
use crate::obstacle::Obstacle;
use crate::pose::Pose;
use crate::random::Random;

/// From the tick that asks for a ping until its trigger pulse is surely over, microseconds.
const TRIGGER_US: u64 = 806;
/// From the trigger until the burst has left and the echo pin rises, microseconds (HC-SR04: 8 cycles and settling).
const BURST_US: u64 = 650;
/// What the burst may take longer.
const LATE_BURST_US: u64 = 350;
/// An echo that ended so shortly before a tick or after it would be heard in this tick or in the next, as it happens.
const BEFORE_TICK_US: u64 = 40;
const AFTER_TICK_US: u64 = 300;
const TICK_US: u64 = 1_000;
/// Echo time of a millimetre as the firmware converts it at its default speed of sound, microseconds.
const MILLIMETRE_US: f64 = 2e3 / 343.0;
/// The rover's echo timer gives up after this time: later than any echo from the greatest range (23.3 ms), sooner
/// than the next sensor's turn.
const TIMEOUT_US: u64 = 27_000;

/// An echo as the firmware's timer sees it; 0 µs is a timeout.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Echo {
    /// 0 left, 1 centre, 2 right.
    pub sensor: u8,
    /// How long the echo pin is high, µs; 0 is a timeout.
    pub echo_us: u32,
}

/// The three sensors and the echoes that are under way.
pub struct Sonar {
    config: config::Sonar,
    random: Random,
    sound_speed: f64,
    pending: [Option<(u64, u32)>; 3],
}

impl Sonar {
    /// Sensors that rest; `seed` draws the air's speed of sound.
    pub fn new(config: &config::Sonar, seed: u64) -> Self {
        let mut random = Random::stream(seed, "sonar");
        let sound_speed =
            config.sound_speed * (1.0 + random.symmetric(config.sound_speed_tolerance));
        Self {
            config: config.clone(),
            random,
            sound_speed,
            pending: [None; 3],
        }
    }

    /// True range of `sensor` in metres, None when nothing stands in its cone within reach.
    pub fn true_range(&self, sensor: usize, pose: Pose, obstacles: &[Obstacle]) -> Option<f64> {
        let [x, y, yaw] = self.config.mounts[sensor];
        let eye = pose.compose(x, y, yaw);
        obstacles
            .iter()
            .filter(|obstacle| obstacle.height > self.config.mount_height)
            .filter_map(|obstacle| cone_range(eye, self.config.half_angle, obstacle))
            .min_by(f64::total_cmp)
            .filter(|range| *range <= self.config.maximum_range)
            .map(|range| range.max(self.config.minimum_range))
    }

    /// Starts a ranging; a sensor that still waits for its echo ignores the trigger, as the part does.
    pub fn trigger(
        &mut self,
        sensor: u8,
        now_us: u64,
        pose: Pose,
        obstacles: &[Obstacle],
        faults: &[Option<SonarFault>; 3],
    ) {
        let index = usize::from(sensor);
        if index >= self.pending.len() || self.pending[index].is_some() {
            return;
        }
        let dropped = self.random.uniform() < self.config.dropout;
        let noise = self.random.normal();
        let fault = faults[index];
        if fault == Some(SonarFault::Dead) {
            return;
        }
        let echo = match fault {
            Some(SonarFault::Near(range)) => Some(range),
            Some(SonarFault::Deaf) => None,
            _ => self.true_range(index, pose, obstacles).filter(|_| !dropped),
        };
        let echo = echo.map(|range| {
            let sigma = self.config.noise + self.config.noise_fraction * range;
            let measured = (range + sigma * noise).max(self.config.minimum_range);
            middle_of_millimetre(2e6 * measured / self.sound_speed)
        });
        self.pending[index] = Some(match echo {
            Some(echo_us) => (
                now_us + TRIGGER_US + burst_us(echo_us) + u64::from(echo_us),
                echo_us,
            ),
            None => (now_us + TIMEOUT_US, 0),
        });
    }

    /// The echo that `sensor` is going to hear, for a rig that makes a pulse of it; 0 µs: none.
    pub fn expected(&self, sensor: u8) -> Option<Echo> {
        let (_, echo_us) = (*self.pending.get(usize::from(sensor))?)?;
        Some(Echo { sensor, echo_us })
    }

    /// The echo that has come back by `now_us`, at most one a tick.
    pub fn poll(&mut self, now_us: u64) -> Option<Echo> {
        for (sensor, slot) in self.pending.iter_mut().enumerate() {
            if let Some((due_us, echo_us)) = *slot {
                if due_us <= now_us {
                    *slot = None;
                    return Some(Echo {
                        sensor: sensor as u8,
                        echo_us,
                    });
                }
            }
        }
        None
    }
}

/// The echo in the middle of the firmware's millimetre, so that a stamp which is 2 us late makes no other one of it.
fn middle_of_millimetre(echo_us: f64) -> u32 {
    (((echo_us / MILLIMETRE_US).floor() + 0.5) * MILLIMETRE_US).round() as u32
}

/// Length of the burst before an echo: such that the echo does not end while the firmware looks for it.
/// `hil_tests/rover_hil/emulator/board.py` has the same rule for the edges of the pin.
fn burst_us(echo_us: u32) -> u64 {
    let end = (TRIGGER_US + BURST_US + u64::from(echo_us)) % TICK_US;
    if (AFTER_TICK_US..TICK_US - BEFORE_TICK_US).contains(&end) {
        BURST_US
    } else {
        BURST_US + LATE_BURST_US
    }
}

/// Nearest point of a disc inside the cone that opens at `eye`: straight at its centre, or along an edge of the cone.
fn cone_range(eye: Pose, half_angle: f64, obstacle: &Obstacle) -> Option<f64> {
    let (dx, dy) = (obstacle.x - eye.x, obstacle.y - eye.y);
    let distance = dx.hypot(dy);
    if distance <= obstacle.radius {
        return Some(0.0);
    }
    let (sine, cosine) = eye.heading.sin_cos();
    let bearing = (cosine * dy - sine * dx).atan2(cosine * dx + sine * dy);
    if bearing.abs() <= half_angle {
        return Some(distance - obstacle.radius);
    }
    let off_axis = bearing.abs() - half_angle;
    let miss = distance * off_axis.sin();
    if off_axis >= std::f64::consts::FRAC_PI_2 || miss > obstacle.radius {
        return None;
    }
    Some(distance * off_axis.cos() - (obstacle.radius * obstacle.radius - miss * miss).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn post(x: f64, y: f64) -> Obstacle {
        Obstacle {
            x,
            y,
            radius: 0.05,
            height: 0.3,
        }
    }

    const HERE: Pose = Pose {
        x: 0.0,
        y: 0.0,
        heading: 0.0,
    };
    const CENTRE: usize = 1;

    fn exact() -> Sonar {
        let config = config::Sonar {
            dropout: 0.0,
            noise: 0.0,
            noise_fraction: 0.0,
            sound_speed_tolerance: 0.0,
            ..Default::default()
        };
        Sonar::new(&config, 1)
    }

    #[test]
    fn the_range_goes_to_the_near_side_of_what_stands_in_the_cone() {
        let sonar = exact();
        let range = |obstacle| sonar.true_range(CENTRE, HERE, &[obstacle]);
        assert!((range(post(1.12, 0.0)).unwrap() - 0.95).abs() < 1e-9);
        assert_eq!(range(post(1.0, 0.6)), None, "beside the cone");
        assert_eq!(range(post(-1.0, 0.0)), None, "behind");
        assert_eq!(range(post(5.0, 0.0)), None, "too far");
        assert_eq!(
            range(Obstacle {
                height: 0.05,
                ..post(1.0, 0.0)
            }),
            None,
            "too low"
        );
        let edge = range(post(1.12, 0.29)).unwrap();
        assert!(
            edge > 0.95 && edge < 1.2,
            "its part inside the cone: {edge}"
        );
    }

    #[test]
    fn an_echo_takes_the_sounds_way_there_and_back_and_comes_once() {
        let mut sonar = exact();
        sonar.trigger(1, 0, HERE, &[post(1.12, 0.0)], &[None; 3]);
        let expected = sonar.expected(1).unwrap();
        assert!((f64::from(expected.echo_us) - 2e6 * 0.95 / 343.0).abs() < 4.0);
        assert_eq!(sonar.poll(5000), None);
        let due = (5000..30_000).step_by(1000).find_map(|now| sonar.poll(now));
        assert_eq!(due, Some(expected));
        assert_eq!(sonar.poll(60_000), None);
    }

    #[test]
    fn no_echo_is_a_timeout_and_a_dead_sensor_says_nothing() {
        let mut sonar = exact();
        sonar.trigger(0, 0, HERE, &[], &[None; 3]);
        assert_eq!(sonar.poll(TIMEOUT_US - 1), None);
        assert_eq!(
            sonar.poll(TIMEOUT_US),
            Some(Echo {
                sensor: 0,
                echo_us: 0
            })
        );
        sonar.trigger(0, 0, HERE, &[], &[Some(SonarFault::Dead), None, None]);
        assert_eq!((sonar.expected(0), sonar.poll(u64::MAX)), (None, None));
    }

    #[test]
    fn no_echo_ends_near_the_moment_at_which_the_firmware_looks() {
        for echo_us in 100..24_000 {
            let end = (TRIGGER_US + burst_us(echo_us) + u64::from(echo_us)) % TICK_US;
            assert!(
                (AFTER_TICK_US..TICK_US - BEFORE_TICK_US).contains(&end),
                "{echo_us}"
            );
        }
    }
}
