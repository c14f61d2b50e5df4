//! The inertial sensor on base_link: what an LSM6DSO has in its registers, with bias, scale error, noise and warming.

use crate::attitude::{turned_back, Stance};
use crate::config;
use crate::random::Random;

/// Radians per second of one step of the gyroscope at 250 deg/s.
const RATE_STEP: f64 = 8.75e-3 * std::f64::consts::PI / 180.0;
/// m/s² of one step of the accelerometer at 2 g.
const FELT_STEP: f64 = 0.061e-3 * GRAVITY;
const GRAVITY: f64 = 9.80665;
/// Time constant of the accelerometer's low-pass filter, s.
const FILTER_S: f64 = 5e-3;
/// Steps of the thermometer in a kelvin, and where it reads 0, °C.
const KELVIN_STEPS: f64 = 256.0;
const ZERO_CELSIUS: f64 = 25.0;

/// Registers: rates about and accelerations along base_link's axes, and the temperature.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Registers {
    /// 8.75 mdeg/s.
    pub gyro: [i16; 3],
    /// 0.061 mg.
    pub acceleration: [i16; 3],
    /// 1/256 K from 25 °C.
    pub temperature: i16,
}

/// The sensor and the motion that it has felt so far.
pub struct Inertial {
    config: config::Inertial,
    random: Random,
    rate_bias: [f64; 3],
    rate_bias_per_kelvin: [f64; 3],
    rate_scale: f64,
    felt_bias: [f64; 3],
    last: Option<(Stance, [f64; 2])>,
    filtered: [f64; 3],
    /// What it shows now.
    pub registers: Registers,
}

impl Inertial {
    /// Switched on with the world; `seed` draws what tells one part from the other.
    pub fn new(config: &config::Inertial, seed: u64) -> Self {
        let mut random = Random::stream(seed, "inertial");
        let mut draw = |sigma: f64| std::array::from_fn(|_| sigma * random.normal());
        let (rate_bias, rate_bias_per_kelvin, felt_bias) = (
            draw(config.rate_bias),
            draw(config.rate_bias_per_kelvin),
            draw(config.felt_bias),
        );
        let rate_scale = 1.0 + config.rate_scale * random.normal();
        Self {
            config: config.clone(),
            random,
            rate_bias,
            rate_bias_per_kelvin,
            rate_scale,
            felt_bias,
            last: None,
            filtered: [0.0, 0.0, GRAVITY],
            registers: Registers::default(),
        }
    }

    /// One step of `dt` seconds that has brought the rover to `stance`. `lift`: vertical acceleration, m/s².
    pub fn step(&mut self, now_us: u64, stance: Stance, lift: f64, dt: f64) {
        let (before, speed_before) = self.last.unwrap_or((stance, [0.0; 2]));
        let speed = [
            (stance.pose.x - before.pose.x) / dt,
            (stance.pose.y - before.pose.y) / dt,
        ];
        self.last = Some((stance, speed));
        let rotation = stance.rotation();
        let world = [
            (speed[0] - speed_before[0]) / dt,
            (speed[1] - speed_before[1]) / dt,
            GRAVITY + lift,
        ];
        let felt = turned_back(&rotation, &world);
        let share = dt / (FILTER_S + dt);
        for (filtered, felt) in self.filtered.iter_mut().zip(felt) {
            *filtered += share * (felt - *filtered);
        }
        // Rates of roll, pitch and heading as rates about the axes of the body.
        let change = |now: f64, then: f64| (now - then) / dt;
        let roll = change(stance.attitude.roll, before.attitude.roll);
        let pitch = change(stance.attitude.pitch, before.attitude.pitch);
        let yaw = change(stance.pose.heading, before.pose.heading);
        let (sr, cr) = stance.attitude.roll.sin_cos();
        let (sp, cp) = stance.attitude.pitch.sin_cos();
        let rates = [
            roll - yaw * sp,
            pitch * cr + yaw * cp * sr,
            yaw * cp * cr - pitch * sr,
        ];
        let warm =
            self.config.warming * (1.0 - (-(now_us as f64) * 1e-6 / self.config.warming_s).exp());
        let shaken = if speed == [0.0; 2] {
            0.0
        } else {
            self.config.vibration
        };
        let mut noise = |sigma: f64| sigma * f64::from(self.random.quick_normal());
        let gyro = std::array::from_fn(|axis| {
            let bias = self.rate_bias[axis] + self.rate_bias_per_kelvin[axis] * warm;
            steps(
                self.rate_scale * rates[axis] + bias + noise(self.config.rate_noise),
                RATE_STEP,
            )
        });
        let acceleration = std::array::from_fn(|axis| {
            let felt = self.filtered[axis] + self.felt_bias[axis];
            steps(felt + noise(self.config.felt_noise + shaken), FELT_STEP)
        });
        let celsius = self.config.celsius + warm;
        self.registers = Registers {
            gyro,
            acceleration,
            temperature: steps(celsius - ZERO_CELSIUS, 1.0 / KELVIN_STEPS),
        };
    }
}

fn steps(value: f64, step: f64) -> i16 {
    (value / step).round().clamp(-32_768.0, 32_767.0) as i16
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::attitude::Attitude;
    use crate::pose::Pose;

    const LEVEL: Stance = Stance {
        pose: Pose {
            x: 1.0,
            y: 1.0,
            heading: 0.5,
        },
        attitude: Attitude {
            roll: 0.0,
            pitch: 0.0,
        },
    };

    fn exact() -> Inertial {
        let config = config::Inertial {
            rate_bias: 0.0,
            rate_bias_per_kelvin: 0.0,
            rate_scale: 0.0,
            felt_bias: 0.0,
            rate_noise: 0.0,
            felt_noise: 0.0,
            vibration: 0.0,
            ..Default::default()
        };
        Inertial::new(&config, 1)
    }

    #[test]
    fn a_rover_at_rest_feels_gravity_where_up_is() {
        let mut part = exact();
        let leaning = Stance {
            attitude: Attitude {
                roll: 0.1,
                pitch: -0.2,
            },
            ..LEVEL
        };
        (0..200).for_each(|ms| part.step(ms * 1000, leaning, 0.0, 1e-3));
        let felt = part
            .registers
            .acceleration
            .map(|v| f64::from(v) * FELT_STEP);
        let up = [
            0.2_f64.sin(),
            0.1_f64.sin() * 0.2_f64.cos(),
            0.1_f64.cos() * 0.2_f64.cos(),
        ];
        for (felt, up) in felt.into_iter().zip(up) {
            assert!((felt - GRAVITY * up).abs() < 1e-3, "{felt}");
        }
        assert_eq!(part.registers.gyro, [0; 3]);
    }

    #[test]
    fn a_turn_is_a_rate_and_a_curve_pushes_to_its_inside() {
        let mut part = exact();
        for ms in 0..500 {
            let heading = 1e-3 * ms as f64;
            let pose = Pose {
                x: 1.0 + 0.3 * heading.sin(),
                y: 1.0 - 0.3 * heading.cos(),
                heading,
            };
            part.step(ms * 1000, Stance { pose, ..LEVEL }, 0.0, 1e-3);
        }
        assert!((f64::from(part.registers.gyro[2]) * RATE_STEP - 1.0).abs() < 1e-3);
        assert!((f64::from(part.registers.acceleration[1]) * FELT_STEP - 0.3).abs() < 0.01);
    }

    #[test]
    fn parts_differ_and_one_seed_gives_one_part() {
        let part = |seed| {
            let mut part = Inertial::new(&config::Inertial::default(), seed);
            (0..100).for_each(|ms| part.step(ms * 1000, LEVEL, 0.0, 1e-3));
            part.registers
        };
        assert_eq!(part(1), part(1));
        assert_ne!(part(1), part(2));
    }
}
