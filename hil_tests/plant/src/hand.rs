//! Somebody's hands around a rover that is lifted: it goes up with a jerk and is never held still.

use std::f64::consts::TAU;

use crate::random::Random;

/// Up in so many seconds by so many metres, with the acceleration of half a sine and back.
const RISE_S: f64 = 0.5;
const RISE_M: f64 = 0.15;
/// Sway of held things, radians and hertz.
const SWAY: f64 = 0.05;
const SWAY_HZ: f64 = 1.3;

/// Holds the rover, or has done, or will.
pub struct Hand {
    random: Random,
    holding: bool,
    since_s: f64,
    phases: [f64; 2],
}

impl Hand {
    /// Not holding it.
    pub fn new(seed: u64) -> Self {
        Self {
            random: Random::stream(seed, "hand"),
            holding: false,
            since_s: 0.0,
            phases: [0.0; 2],
        }
    }

    /// `dt` seconds later.
    pub fn step(&mut self, holding: bool, dt: f64) {
        if holding && !self.holding {
            self.since_s = 0.0;
            self.phases = std::array::from_fn(|_| TAU * self.random.uniform());
        }
        self.holding = holding;
        self.since_s += dt;
    }

    /// Acceleration upwards, m/s².
    pub fn lift(&self) -> f64 {
        if !self.holding || self.since_s > RISE_S {
            return 0.0;
        }
        let frequency = TAU / RISE_S;
        RISE_M * frequency / RISE_S * (frequency * self.since_s).sin()
    }

    /// Roll and pitch, radians.
    pub fn tremor(&self) -> [f64; 2] {
        if !self.holding {
            return [0.0; 2];
        }
        let grown = SWAY * (self.since_s / RISE_S).min(1.0);
        self.phases
            .map(|phase| grown * (TAU * SWAY_HZ * self.since_s + phase).sin())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_lifted_rises_by_a_hand_and_sways_until_it_is_put_down() {
        let mut hand = Hand::new(1);
        let (mut speed, mut height, mut most) = (0.0, 0.0, 0.0_f64);
        for _ in 0..2_000 {
            hand.step(true, 1e-3);
            speed += hand.lift() * 1e-3;
            height += speed * 1e-3;
            most = most.max(hand.tremor()[0].abs());
        }
        assert!((height - RISE_M).abs() < 0.01, "{height}");
        assert!(most > 0.9 * SWAY);
        hand.step(false, 1e-3);
        assert_eq!((hand.lift(), hand.tremor()), (0.0, [0.0; 2]));
    }
}
