//! What a real thermal camera does to pictures and to their delivery; everything here is off unless a world file
//! switches it on, and draws from a stream of its own.

use serde::Deserialize;

use crate::random::Random;

/// Sizes of every effect; the default has none.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Bolometer {
    /// Thermal time constant of a pixel, s.
    pub time_constant: f64,
    /// Mean of the exponential part of the latency, µs.
    pub jitter_us: f64,
    /// Shares of frames that never come, that come twice, and that are late.
    pub dropped: f64,
    /// As for the dropped.
    pub repeated: f64,
    /// As for the dropped.
    pub late: f64,
    /// How late, µs.
    pub late_us: f64,
    /// The camera's clock against the world's: at time zero, µs, and its rate.
    pub clock_offset_us: f64,
    /// Parts per million that it is fast.
    pub clock_ppm: f64,
    /// Standard deviation of the level between calibrations, kelvin, and of the slope from edge to edge.
    pub drift: f64,
    /// As for the level.
    pub drift_slope: f64,
    /// Correlation time of both, s.
    pub drift_time: f64,
    /// Turning faster than this may close the shutter, rad/s; 0: never.
    pub shutter_turning: f64,
    /// For so long, µs.
    pub shutter_us: u64,
    /// And not again for so long, µs.
    pub shutter_rest_us: u64,
    /// Spots on the window that stay.
    pub dirt: usize,
    /// Drops that land a second, and how long one lasts, s.
    pub drops_per_second: f64,
    /// As said above, s.
    pub drop_lasts: f64,
    /// Radius of spot and drop, pixels, and the share of the ground's radiation that comes through its middle.
    pub spot_radius: f64,
    /// As for the radius.
    pub spot_transmission: f64,
    /// Of the window, kelvin.
    pub window: f64,
    /// Glints a second, their strength in kelvin, and how long one lasts, s.
    pub glints_per_second: f64,
    /// As for the glints.
    pub glint: f64,
    /// As for the glints.
    pub glint_lasts: f64,
}

/// Something before the lens or in the scene: column, row, radius in pixels, end of its life in µs.
struct Spot {
    u: f64,
    v: f64,
    radius: f64,
    until_us: u64,
    strength: f64,
}

/// The sensor's state.
pub struct Sensor {
    config: Bolometer,
    random: Random,
    width: usize,
    height: usize,
    spots: Vec<Spot>,
    glints: Vec<Spot>,
    level: [f64; 3],
    before_us: u64,
    delivered_us: u64,
    closed_until_us: u64,
    closable_us: u64,
    /// Calibrations that it has begun by itself.
    pub calibrations: u64,
}

impl Sensor {
    /// A sensor just calibrated, with what dirt is on it.
    pub fn new(config: &Bolometer, width: usize, height: usize, seed: u64) -> Self {
        let mut sensor = Self {
            config: config.clone(),
            random: Random::stream(seed, "bolometer"),
            width,
            height,
            spots: Vec::new(),
            glints: Vec::new(),
            level: [0.0; 3],
            before_us: 0,
            delivered_us: 0,
            closed_until_us: 0,
            closable_us: 0,
            calibrations: 0,
        };
        for _ in 0..config.dirt {
            let spot = sensor.spot(u64::MAX, 1.0);
            sensor.spots.push(spot);
        }
        sensor
    }

    /// Whether the sensor takes its time to follow the scene.
    pub fn is_slow(&self) -> bool {
        self.config.time_constant > 0.0
    }

    /// Whether its own calibration keeps the shutter closed now; a turn may begin one.
    pub fn shut(&mut self, now_us: u64, turn_rate: f64) -> bool {
        let limit = self.config.shutter_turning;
        if limit > 0.0 && turn_rate.abs() > limit && now_us >= self.closable_us {
            self.closed_until_us = now_us + self.config.shutter_us;
            self.closable_us = self.closed_until_us + self.config.shutter_rest_us;
            self.calibrations += 1;
            self.level = [0.0; 3];
        }
        now_us < self.closed_until_us
    }

    /// The time that the camera writes on a picture.
    pub fn stamp(&self, exposure_us: u64) -> u64 {
        let own = exposure_us as f64 * self.config.clock_ppm * 1e-6 + self.config.clock_offset_us;
        (exposure_us as f64 + own).max(0.0).round() as u64
    }

    /// When a picture that would come at `due_us` really comes: never, once or twice, and none overtakes another.
    pub fn deliver(&mut self, due_us: u64) -> Vec<u64> {
        let config = &self.config;
        let (jitter, late) = (config.jitter_us, config.late);
        if jitter + late + config.dropped + config.repeated == 0.0 {
            return vec![due_us];
        }
        let (dropped, repeated, late_us) = (config.dropped, config.repeated, config.late_us);
        let mut delay = -jitter * (1.0 - self.random.uniform()).ln();
        if self.random.uniform() < late {
            delay += late_us;
        }
        let is_dropped = self.random.uniform() < dropped;
        let is_repeated = self.random.uniform() < repeated;
        if is_dropped {
            return Vec::new();
        }
        let due_us = (due_us + (delay / 1000.0).round() as u64 * 1000).max(self.delivered_us);
        self.delivered_us = due_us;
        vec![due_us; if is_repeated { 2 } else { 1 }]
    }

    /// Puts dirt, drops, glints and drift into what the lens shows, kelvin.
    pub fn disturb(&mut self, exposure_us: u64, scene: &mut [f32]) {
        let dt = exposure_us.saturating_sub(self.before_us) as f64 * 1e-6;
        self.before_us = exposure_us;
        self.come_and_go(exposure_us, dt);
        let (window, through) = (self.config.window as f32, self.config.spot_transmission);
        for spot in &self.spots {
            self.cover(spot, |index, part| {
                let lost = ((1.0 - through) * part) as f32;
                scene[index] += lost * (window - scene[index]);
            });
        }
        for spot in &self.glints {
            self.cover(spot, |index, part| {
                scene[index] += (spot.strength * part) as f32;
            });
        }
        if self.config.drift + self.config.drift_slope > 0.0 {
            self.wander(dt);
            self.add_level(scene);
        }
    }

    fn come_and_go(&mut self, now_us: u64, dt: f64) {
        let drops = self.config.drops_per_second * dt;
        if drops > 0.0 && self.random.uniform() < drops {
            let until_us = now_us + (self.config.drop_lasts * 1e6) as u64;
            let spot = self.spot(until_us, 1.0);
            self.spots.push(spot);
        }
        let glints = self.config.glints_per_second * dt;
        if glints > 0.0 && self.random.uniform() < glints {
            let until_us = now_us + (self.config.glint_lasts * 1e6) as u64;
            let strength = self.config.glint * (0.3 + 0.7 * self.random.uniform());
            let mut spot = self.spot(until_us, strength);
            spot.radius = 0.8 + 1.5 * self.random.uniform();
            self.glints.push(spot);
        }
        self.spots.retain(|spot| spot.until_us > now_us);
        self.glints.retain(|spot| spot.until_us > now_us);
    }

    fn spot(&mut self, until_us: u64, strength: f64) -> Spot {
        Spot {
            u: self.random.uniform() * self.width as f64,
            v: self.random.uniform() * self.height as f64,
            radius: self.config.spot_radius * (0.5 + self.random.uniform()),
            until_us,
            strength,
        }
    }

    /// Calls `change(index, part)` for the pixels of a spot; its part is 1 in the middle and 0 at the edge.
    fn cover(&self, spot: &Spot, mut change: impl FnMut(usize, f64)) {
        let span = |middle: f64, size: usize| {
            let low = (middle - spot.radius).max(0.0) as usize;
            low..((middle + spot.radius).max(0.0) as usize + 1).min(size)
        };
        for row in span(spot.v, self.height) {
            for column in span(spot.u, self.width) {
                let away =
                    (column as f64 - spot.u).hypot(row as f64 - spot.v) / spot.radius.max(0.5);
                if away < 1.0 {
                    change(row * self.width + column, 1.0 - away * away);
                }
            }
        }
    }

    /// Ornstein-Uhlenbeck: the level, and the slopes along and across.
    fn wander(&mut self, dt: f64) {
        let decay = (-dt / self.config.drift_time.max(1e-3)).exp();
        let kick = (1.0 - decay * decay).sqrt();
        let sigmas = [
            self.config.drift,
            self.config.drift_slope,
            self.config.drift_slope,
        ];
        for (level, sigma) in self.level.iter_mut().zip(sigmas) {
            *level = decay * *level + kick * sigma * f64::from(self.random.quick_normal());
        }
    }

    fn add_level(&self, scene: &mut [f32]) {
        let [level, across, down] = self.level;
        let (width, height) = (self.width as f64, self.height as f64);
        for (row, line) in scene.chunks_exact_mut(self.width).enumerate() {
            let here = (level + down * (row as f64 / height - 0.5)) as f32;
            for (column, kelvin) in line.iter_mut().enumerate() {
                *kelvin += here + (across * (column as f64 / width - 0.5)) as f32;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: (usize, usize) = (40, 30);

    fn sensor(config: Bolometer) -> Sensor {
        Sensor::new(&config, SIZE.0, SIZE.1, 1)
    }

    fn even() -> Vec<f32> {
        vec![300.0; SIZE.0 * SIZE.1]
    }

    #[test]
    fn without_effects_nothing_changes() {
        let mut sensor = sensor(Bolometer::default());
        let mut scene = even();
        sensor.disturb(120_000, &mut scene);
        assert_eq!(scene, even());
        assert_eq!(sensor.deliver(180_000), [180_000]);
        assert_eq!(sensor.stamp(120_000), 120_000);
        assert!(!sensor.shut(120_000, 3.0));
    }

    #[test]
    fn frames_come_late_twice_or_never_and_none_overtakes_another() {
        let mut sensor = sensor(Bolometer {
            jitter_us: 20_000.0,
            dropped: 0.2,
            repeated: 0.2,
            late: 0.1,
            late_us: 500_000.0,
            ..Default::default()
        });
        let come: Vec<Vec<u64>> = (0..1000).map(|n| sensor.deliver(n * 120_000)).collect();
        let none = come.iter().filter(|times| times.is_empty()).count();
        let twice = come.iter().filter(|times| times.len() == 2).count();
        assert!((150..250).contains(&none) && (100..220).contains(&twice));
        let all: Vec<u64> = come.into_iter().flatten().collect();
        assert!(all.windows(2).all(|pair| pair[0] <= pair[1]));
        assert!(all.iter().all(|time| time % 1000 == 0));
    }

    #[test]
    fn a_fast_turn_closes_the_shutter_once_and_it_rests_after_that() {
        let mut sensor = sensor(Bolometer {
            shutter_turning: 0.3,
            shutter_us: 1_000_000,
            shutter_rest_us: 10_000_000,
            ..Default::default()
        });
        assert!(!sensor.shut(0, 0.1));
        assert!(sensor.shut(1_000_000, -0.5) && sensor.shut(1_900_000, 0.0));
        assert!(!sensor.shut(2_000_000, 0.5) && !sensor.shut(11_000_000, 0.5));
        assert!(sensor.shut(12_000_000, 0.5));
        assert_eq!(sensor.calibrations, 2);
    }

    #[test]
    fn dirt_hides_the_scene_a_glint_outshines_it_and_drift_moves_it() {
        let mut dirty = sensor(Bolometer {
            dirt: 3,
            spot_radius: 5.0,
            spot_transmission: 0.2,
            window: 290.0,
            ..Default::default()
        });
        let mut scene = even();
        dirty.disturb(120_000, &mut scene);
        let coldest = scene.iter().copied().fold(f32::INFINITY, f32::min);
        assert!((291.0..294.0).contains(&coldest), "{coldest}");
        let mut sunny = sensor(Bolometer {
            glints_per_second: 1000.0,
            glint: 20.0,
            glint_lasts: 0.3,
            ..Default::default()
        });
        let mut scene = even();
        sunny.disturb(120_000, &mut scene);
        assert!(scene.iter().copied().fold(0.0, f32::max) > 304.0);
        let mut drifting = sensor(Bolometer {
            drift: 1.0,
            drift_time: 10.0,
            ..Default::default()
        });
        let mut scene = even();
        drifting.disturb(5_000_000, &mut scene);
        assert!(scene[0] != 300.0 && (scene[0] - scene[500]).abs() < 1e-4);
    }
}
