//! How the rover leans: roll and pitch beside the pose in the plane, and how uneven ground makes it lean.

use std::f64::consts::{FRAC_1_SQRT_2, TAU};

use crate::config;
use crate::pose::Pose;
use crate::random::Random;
use crate::terrain::Point;

/// Waves that add up to the slope along one axis of the map.
const WAVES: usize = 12;

/// Radians about base_link's x (left side up) and then its y (nose down), as REP 103 has them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Attitude {
    /// Left side up.
    pub roll: f64,
    /// Nose down.
    pub pitch: f64,
}

/// Where base_link is, and how it leans.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stance {
    /// On the plane.
    pub pose: Pose,
    /// Out of it.
    pub attitude: Attitude,
}

impl Stance {
    /// On level ground.
    pub fn level(pose: Pose) -> Self {
        Self {
            pose,
            attitude: Attitude::default(),
        }
    }

    /// From directions in base_link to directions in the map, row by row: Rz(heading) Ry(pitch) Rx(roll).
    pub fn rotation(&self) -> [Point; 3] {
        let (sine, cosine) = self.pose.heading.sin_cos();
        let (sr, cr) = self.attitude.roll.sin_cos();
        let (sp, cp) = self.attitude.pitch.sin_cos();
        [
            [
                cosine * cp,
                cosine * sp * sr - sine * cr,
                cosine * sp * cr + sine * sr,
            ],
            [
                sine * cp,
                sine * sp * sr + cosine * cr,
                sine * sp * cr - cosine * sr,
            ],
            [-sp, cp * sr, cp * cr],
        ]
    }
}

/// `rotation` applied to a direction.
pub fn turned(rotation: &[Point; 3], v: &Point) -> Point {
    std::array::from_fn(|row| {
        rotation[row][0] * v[0] + rotation[row][1] * v[1] + rotation[row][2] * v[2]
    })
}

/// The way back: the transpose of `rotation` applied to a direction.
pub fn turned_back(rotation: &[Point; 3], v: &Point) -> Point {
    std::array::from_fn(|column| {
        rotation[0][column] * v[0] + rotation[1][column] * v[1] + rotation[2][column] * v[2]
    })
}

/// A smooth random slope of the map that the wheels ride on. The ground's rasters stay as they are: what tilts the rover
/// is smaller than their cells, or too wide to hide anything.
pub struct Unevenness {
    /// Of the slopes along x and y: wave number along x and y, phase.
    waves: [Vec<[f64; 3]>; 2],
    amplitude: f64,
}

impl Unevenness {
    /// Drawn from `seed`.
    pub fn new(config: &config::Unevenness, seed: u64) -> Self {
        let mut random = Random::stream(seed, "unevenness");
        let mut wave = |_| {
            let direction = TAU * random.uniform();
            let number = TAU / (config.length * (1.0 + 2.0 * random.uniform()));
            let phase = TAU * random.uniform();
            [number * direction.cos(), number * direction.sin(), phase]
        };
        let waves = std::array::from_fn(|_| (0..WAVES).map(&mut wave).collect());
        // A sine's mean square is a half, and both axes share the whole tilt.
        let amplitude = config.tilt.tan() * FRAC_1_SQRT_2 * (2.0 / WAVES as f64).sqrt();
        Self { waves, amplitude }
    }

    /// How a rover at `pose` leans.
    pub fn attitude(&self, pose: Pose) -> Attitude {
        if self.amplitude == 0.0 {
            return Attitude::default();
        }
        let slope = |axis: usize| {
            let sum: f64 = self.waves[axis]
                .iter()
                .map(|[kx, ky, phase]| (kx * pose.x + ky * pose.y + phase).sin())
                .sum();
            self.amplitude * sum
        };
        let (east, north) = (slope(0), slope(1));
        let (sine, cosine) = pose.heading.sin_cos();
        let pitch = -(cosine * east + sine * north).atan();
        // Across a rover that is pitched already.
        let roll = ((cosine * north - sine * east) * pitch.cos()).atan();
        Attitude { roll, pitch }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const POSE: Pose = Pose {
        x: 0.7,
        y: 1.9,
        heading: 0.6,
    };

    #[test]
    fn a_level_stance_turns_by_the_heading_alone() {
        let turned = turned(&Stance::level(POSE).rotation(), &[1.0, 0.0, 0.5]);
        assert_eq!(turned, [0.6_f64.cos(), 0.6_f64.sin(), 0.5]);
    }

    #[test]
    fn positive_roll_lifts_the_left_side_and_positive_pitch_lowers_the_nose() {
        let stance = |roll, pitch| Stance {
            pose: POSE,
            attitude: Attitude { roll, pitch },
        };
        assert!(turned(&stance(0.1, 0.0).rotation(), &[0.0, 1.0, 0.0])[2] > 0.09);
        assert!(turned(&stance(0.0, 0.1).rotation(), &[1.0, 0.0, 0.0])[2] < -0.09);
        let rotation = stance(0.2, -0.3).rotation();
        let back = turned_back(&rotation, &turned(&rotation, &[0.1, 0.2, 0.3]));
        for (there, here) in back.into_iter().zip([0.1, 0.2, 0.3]) {
            assert!((there - here).abs() < 1e-12);
        }
    }

    #[test]
    fn the_tilt_over_the_field_has_the_size_that_was_asked_for() {
        let config = config::Unevenness {
            tilt: 2.0_f64.to_radians(),
            ..Default::default()
        };
        let mut squares = Vec::new();
        for seed in 0..20 {
            let ground = Unevenness::new(&config, seed);
            for i in 0..400 {
                let pose = Pose {
                    x: f64::from(i % 20) * 0.2,
                    y: f64::from(i / 20) * 0.2,
                    heading: 0.3,
                };
                let lean = ground.attitude(pose);
                squares.push(lean.roll.powi(2) + lean.pitch.powi(2));
            }
        }
        let rms = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
        assert!((rms.to_degrees() - 2.0).abs() < 0.1, "{}", rms.to_degrees());
    }

    #[test]
    fn a_rover_that_turns_about_leans_the_other_way() {
        let config = config::Unevenness {
            tilt: 0.05,
            ..Default::default()
        };
        let ground = Unevenness::new(&config, 3);
        let there = ground.attitude(POSE);
        let about = ground.attitude(Pose {
            heading: POSE.heading + std::f64::consts::PI,
            ..POSE
        });
        assert!((there.pitch + about.pitch).abs() < 1e-9);
        assert!((there.roll + about.roll).abs() < 1e-3);
    }
}
