//! Moments in which a wheel loses its grip: now and then it gives the ground only a part of its travel.

use crate::config;
use crate::random::Random;

/// Both wheels, each with bursts of its own.
pub struct SlipBursts {
    config: config::SlipBursts,
    random: Random,
    /// Travel of the surface until the burst, or the grip, is over, metres.
    left_m: [f64; 2],
    slipping: [bool; 2],
}

impl SlipBursts {
    /// Drawn from `seed`.
    pub fn new(config: &config::SlipBursts, seed: u64) -> Self {
        let mut bursts = Self {
            config: config.clone(),
            random: Random::stream(seed, "slip bursts"),
            left_m: [0.0; 2],
            slipping: [true; 2],
        };
        for wheel in 0..2 {
            bursts.change(wheel);
        }
        bursts
    }

    /// Part of the travel that the ground does not get while the wheel turns by `travel` metres of its surface.
    pub fn slip(&mut self, wheel: usize, travel: f64) -> f64 {
        if self.config.mean == 0.0 {
            return 0.0;
        }
        self.left_m[wheel] -= travel.abs();
        if self.left_m[wheel] < 0.0 {
            self.change(wheel);
        }
        if self.slipping[wheel] {
            self.config.size
        } else {
            0.0
        }
    }

    /// Lengths are exponential, so that a burst comes without warning.
    fn change(&mut self, wheel: usize) {
        self.slipping[wheel] = !self.slipping[wheel];
        let grip = self.config.length * (self.config.size / self.config.mean - 1.0).max(0.0);
        let mean = if self.slipping[wheel] {
            self.config.length
        } else {
            grip
        };
        self.left_m[wheel] = -mean * (1.0 - self.random.uniform()).ln();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bursts_add_up_to_the_mean_that_was_asked_for_and_wheels_slip_apart() {
        let config = config::SlipBursts {
            mean: 0.03,
            ..Default::default()
        };
        let mut bursts = SlipBursts::new(&config, 4);
        let (mut lost, mut alike, steps) = ([0.0; 2], 0, 4_000_000);
        for _ in 0..steps {
            let slip: [f64; 2] = std::array::from_fn(|wheel| bursts.slip(wheel, 2e-4));
            lost = [lost[0] + slip[0], lost[1] + slip[1]];
            alike += i32::from(slip[0] > 0.0 && slip[1] > 0.0);
        }
        for wheel in lost {
            let mean = wheel / f64::from(steps);
            assert!((mean - 0.03).abs() < 0.004, "{mean}");
        }
        assert!(f64::from(alike) / f64::from(steps) < 0.03);
    }

    #[test]
    fn without_them_nothing_slips_and_nothing_is_drawn() {
        let mut bursts = SlipBursts::new(&config::SlipBursts::default(), 4);
        assert!((0..10_000).all(|_| bursts.slip(0, 0.01) == 0.0));
    }
}
