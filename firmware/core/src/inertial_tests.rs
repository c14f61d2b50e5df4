//! The sensor's arithmetic against closed forms in floating point.

use super::*;

const STEP_RAD_S: f64 = 8.75e-3 * std::f64::consts::PI / 180.0;
const STEP_G: f64 = 0.061e-3;
const RESTING: WheelMotion = WheelMotion {
    resting: true,
    velocity: 0,
    acceleration: 0,
};
const DRIVING: WheelMotion = WheelMotion {
    resting: false,
    ..RESTING
};

/// A sensor with a bias and noise, on a rover that rolls and turns.
struct Part {
    inertial: Inertial,
    now_us: u64,
    bias: [f64; 3],
    bias_per_kelvin: f64,
    kelvin: f64,
    noise: u32,
}

impl Part {
    fn new() -> Self {
        Self {
            inertial: Inertial::default(),
            now_us: 100_000,
            bias: [0.01, -0.02, 0.03],
            bias_per_kelvin: 0.0,
            kelvin: 0.0,
            noise: 1,
        }
    }

    fn sample(&mut self, rates: [f64; 3], felt_g: [f64; 3]) -> InertialSample {
        let bias = self
            .bias
            .map(|bias| bias + self.bias_per_kelvin * self.kelvin);
        let mut noise = || {
            self.noise = self
                .noise
                .wrapping_mul(1_664_525)
                .wrapping_add(1_013_904_223);
            f64::from(self.noise >> 16) / 65_536.0 * 6.0 - 3.0
        };
        InertialSample {
            gyro: std::array::from_fn(|i| {
                ((rates[i] + bias[i]) / STEP_RAD_S + noise()).round() as i16
            }),
            acceleration: felt_g.map(|g| (g / STEP_G + noise()).round() as i16),
            temperature: (self.kelvin * 256.0) as i16,
        }
    }

    /// Samples every 4 ms, ticks every millisecond.
    fn run(&mut self, seconds: f64, wheels: WheelMotion, rates: [f64; 3], felt_g: [f64; 3]) {
        for ms in 0..(seconds * 1000.0) as u64 {
            self.now_us += 1_000;
            let sample = (ms % 4 == 0).then(|| self.sample(rates, felt_g));
            self.inertial.tick(self.now_us, sample, &wheels);
        }
    }

    fn heading(&self) -> f64 {
        f64::from(self.inertial.heading_urad(self.now_us)) * 1e-6
    }
}

const LEVEL: [f64; 3] = [0.0, 0.0, 1.0];

#[test]
fn the_bias_of_a_rest_is_taken_off_and_a_turn_is_what_it_was() {
    let mut part = Part::new();
    part.run(2.0, RESTING, [0.0; 3], LEVEL);
    assert!(part.inertial.is_good());
    let before = part.heading();
    part.run(3.0, DRIVING, [0.0, 0.0, 0.8], LEVEL);
    let turned = part.heading() - before;
    assert!((turned - 2.4).abs() < 0.006, "{turned}");
    assert!((f64::from(part.inertial.rate_mrad_s()) - 800.0).abs() < 3.0);
    let before = part.heading();
    part.run(60.0, DRIVING, [0.0; 3], LEVEL);
    let drift = part.heading() - before;
    assert!(drift.abs() < 0.01, "{drift} rad in a minute");
}

#[test]
fn before_the_first_rest_it_is_not_good_and_a_slow_turn_at_rest_is_no_bias() {
    let mut part = Part::new();
    part.run(2.0, DRIVING, [0.0; 3], LEVEL);
    assert_eq!(part.inertial.status(), Some(gravity_status::SETTLING));
    part.run(3.0, RESTING, [0.0, 0.0, 0.4], LEVEL);
    assert_eq!(part.inertial.status(), Some(gravity_status::SETTLING));
}

#[test]
fn the_bias_follows_the_temperature_once_two_rests_have_shown_how() {
    let mut part = Part::new();
    part.bias_per_kelvin = 4e-4;
    part.run(2.0, RESTING, [0.0; 3], LEVEL);
    // A drive in between, so that no rest is at two temperatures.
    part.run(0.1, DRIVING, [0.0; 3], LEVEL);
    part.kelvin = 5.0;
    part.run(2.0, RESTING, [0.0; 3], LEVEL);
    part.kelvin = 12.0;
    let before = part.heading();
    part.run(20.0, DRIVING, [0.0; 3], LEVEL);
    let drift = part.heading() - before;
    assert!(drift.abs() < 0.01, "{drift}: 0.056 without the temperature");
}

#[test]
fn up_follows_a_lean_at_once_and_is_not_led_astray_by_the_wheels() {
    let mut part = Part::new();
    part.run(2.0, RESTING, [0.0; 3], LEVEL);
    // Nose down by 0.2 rad in half a second.
    for i in 0..125 {
        let pitch = 0.2 * f64::from(i) / 125.0;
        part.run(
            0.004,
            DRIVING,
            [0.0, 0.4, 0.0],
            [-pitch.sin(), 0.0, pitch.cos()],
        );
    }
    let [x, y, z] = part.inertial.up_mm_s2().map(|v| f64::from(v) * 1e-3);
    assert!((x + 9.80665 * 0.2_f64.sin()).abs() < 0.06, "{x}");
    assert!(
        y.abs() < 0.05 && (z - 9.80665 * 0.2_f64.cos()).abs() < 0.06,
        "{y} {z}"
    );

    let mut part = Part::new();
    part.run(2.0, RESTING, [0.0; 3], LEVEL);
    let faster = WheelMotion {
        resting: false,
        velocity: 300_000,
        acceleration: 500_000,
    };
    // 0.5 m/s^2 forwards and 0.3 m/s at 1 rad/s: 2.9 and 1.8 degrees if they were taken for gravity.
    let felt = [0.5 / 9.80665, 0.3 / 9.80665, 1.0];
    part.run(2.0, faster, [0.0, 0.0, 1.0], felt);
    let [x, y, _] = part.inertial.up_mm_s2();
    assert!(x.abs() < 60 && y.abs() < 60, "{x} {y}");
}

#[test]
fn on_a_slope_a_turn_about_the_vertical_counts_in_full() {
    let mut part = Part::new();
    let lean: f64 = 0.3;
    let felt = [0.0, lean.sin(), lean.cos()];
    part.run(4.0, RESTING, [0.0; 3], felt);
    let before = part.heading();
    part.run(
        1.0,
        DRIVING,
        [0.0, 0.5 * lean.sin(), 0.5 * lean.cos()],
        felt,
    );
    let turned = part.heading() - before;
    assert!((turned - 0.5).abs() < 0.01, "{turned}");
}

#[test]
fn a_jolt_is_told_once_and_does_not_move_the_vertical() {
    let mut part = Part::new();
    part.run(2.0, RESTING, [0.0; 3], LEVEL);
    part.inertial.take_shake();
    part.run(0.1, DRIVING, [0.0; 3], [0.0, 0.0, 1.5]);
    assert!((45..=53).contains(&part.inertial.take_shake()));
    assert_eq!(part.inertial.take_shake(), 0);
    assert!((part.inertial.up_mm_s2()[2] - 9_807).abs() < 40);
}

#[test]
fn a_sensor_that_falls_silent_or_repeats_itself_is_lost_until_it_speaks_again() {
    let mut part = Part::new();
    part.run(2.0, RESTING, [0.0; 3], LEVEL);
    for _ in 0..60 {
        part.now_us += 1_000;
        part.inertial.tick(part.now_us, None, &RESTING);
    }
    assert_eq!(part.inertial.loss(), Some(Loss::Silent));
    part.run(0.1, DRIVING, [0.0; 3], LEVEL);
    assert!(part.inertial.is_good(), "the bias is known from before");
    let stuck = part.sample([0.0; 3], LEVEL);
    for _ in 0..30 {
        part.now_us += 4_000;
        part.inertial.tick(part.now_us, Some(stuck), &DRIVING);
    }
    assert_eq!(part.inertial.loss(), Some(Loss::Frozen));
    assert_eq!(part.inertial.status(), Some(gravity_status::LOST));
}

#[test]
fn what_never_spoke_is_not_there_and_not_lost() {
    let mut inertial = Inertial::default();
    for ms in 0..500 {
        inertial.tick(ms * 1_000, None, &RESTING);
    }
    assert_eq!((inertial.status(), inertial.loss()), (None, None));
}
