//! Seeded random numbers. Each consumer owns a stream of its own, so that one more draw in one sensor leaves all
//! others as they were: the same seed gives the same bytes.

/// xoshiro256++ (Blackman and Vigna, public domain), seeded by splitmix64.
#[derive(Clone)]
pub struct Random {
    state: [u64; 4],
}

fn splitmix64(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

impl Random {
    /// The stream `name` of `seed`; the name is hashed with FNV-1a.
    pub fn stream(seed: u64, name: &str) -> Self {
        let mut hash = name.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
        });
        hash ^= seed.wrapping_mul(0xd134_2543_de82_ef95);
        Self {
            state: std::array::from_fn(|_| splitmix64(&mut hash)),
        }
    }

    /// The next 64 bits.
    pub fn bits(&mut self) -> u64 {
        let s = &mut self.state;
        let result = s[0].wrapping_add(s[3]).rotate_left(23).wrapping_add(s[0]);
        let t = s[1] << 17;
        s[2] ^= s[0];
        s[3] ^= s[1];
        s[1] ^= s[2];
        s[0] ^= s[3];
        s[2] ^= t;
        s[3] = s[3].rotate_left(45);
        result
    }

    /// Uniform in [0, 1).
    pub fn uniform(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * (1.0 / 9_007_199_254_740_992.0)
    }

    /// Uniform in [-bound, bound).
    pub fn symmetric(&mut self, bound: f64) -> f64 {
        (2.0 * self.uniform() - 1.0) * bound
    }

    /// Standard normal (Marsaglia's polar method).
    pub fn normal(&mut self) -> f64 {
        loop {
            let u = self.symmetric(1.0);
            let v = self.symmetric(1.0);
            let square = u * u + v * v;
            if square > 0.0 && square < 1.0 {
                return u * (-2.0 * square.ln() / square).sqrt();
            }
        }
    }

    /// Nearly normal, for whole images: the sum of the eight bytes of one draw, scaled to unit variance
    /// (excess kurtosis -0.15, bounded at 4.9 sigma).
    pub fn quick_normal(&mut self) -> f32 {
        const MEAN: f32 = 8.0 * 127.5;
        const SIGMA: f32 = 209.021_52; // sqrt(8 (256^2 - 1) / 12)
        let x = self.bits();
        let pairs = (x & 0x00ff_00ff_00ff_00ff) + ((x >> 8) & 0x00ff_00ff_00ff_00ff);
        let sum = pairs.wrapping_mul(0x0001_0001_0001_0001) >> 48;
        (sum as f32 - MEAN) / SIGMA
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stream_is_its_seed_and_its_name() {
        let first = |seed, name| Random::stream(seed, name).bits();
        assert_eq!(first(1, "drive"), first(1, "drive"));
        assert_ne!(first(1, "drive"), first(2, "drive"));
        assert_ne!(first(1, "drive"), first(1, "sonar"));
    }

    /// Mean and variance of 200,000 draws.
    fn moments(mut draw: impl FnMut() -> f64) -> (f64, f64) {
        let values: Vec<f64> = (0..200_000).map(|_| draw()).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        (
            mean,
            values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / values.len() as f64,
        )
    }

    #[test]
    fn draws_have_the_moments_that_they_promise() {
        let mut random = Random::stream(3, "moments");
        let (mean, variance) = moments(|| random.uniform());
        assert!((mean - 0.5).abs() < 0.005 && (variance - 1.0 / 12.0).abs() < 0.001);
        let (mean, variance) = moments(|| random.normal());
        assert!(mean.abs() < 0.01 && (variance - 1.0).abs() < 0.02);
        let (mean, variance) = moments(|| f64::from(random.quick_normal()));
        assert!(mean.abs() < 0.01 && (variance - 1.0).abs() < 0.02);
    }

    #[test]
    fn bounds_hold() {
        let mut random = Random::stream(4, "bounds");
        for _ in 0..10_000 {
            assert!((0.0..1.0).contains(&random.uniform()));
            assert!((-0.3..0.3).contains(&random.symmetric(0.3)));
        }
    }
}
