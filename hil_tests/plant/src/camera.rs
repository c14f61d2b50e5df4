//! The thermal camera: rays through the lens to the ground, and what the sensor makes of their temperatures.

use crate::attitude::{turned, Stance};
use crate::bolometer::Sensor;
use crate::config;
use crate::faults::CameraFault;
use crate::lens::{distort, undistort};
use crate::random::Random;
use crate::terrain::{Point, Terrain};

/// What a ray that meets no ground sees, kelvin.
const SKY_TEMPERATURE: f32 = 250.0;

/// Beyond this distance from the axis, squared, on the plane one ahead of the lens, no lens of ours shows anything.
const FARTHEST_SQUARE: f64 = 3.0;

/// One picture on its way to the companion.
pub struct Frame {
    /// Number of the frame, from 0; counts on over frames that were not sent.
    pub sequence: u64,
    /// Time of the exposure by the camera's clock, µs.
    pub exposure_us: u64,
    /// When the companion gets it, µs.
    pub delivered_us: u64,
    /// Taken while the shutter was closed: a repetition of the frame before, without depths.
    pub ffc: bool,
    /// Kelvin × 100, row-major.
    pub counts: Vec<u16>,
    /// True pose and attitude of the rover at the exposure.
    pub stance: Stance,
    /// Along the optical axis from the lens to what each pixel saw, metres; infinite for the sky.
    pub depth: Vec<f32>,
}

/// The camera and what its sensor has left over from its last calibration.
pub struct Camera {
    config: config::Camera,
    random: Random,
    /// Directions of the pixels' rays in base_link.
    rays: Vec<Point>,
    vignetting: Vec<f32>,
    pattern: Vec<f32>,
    calibrations: u64,
    sequence: u64,
    next_exposure_us: u64,
    last: Vec<u16>,
    sensor: Sensor,
    /// Of base_link, ahead in m/s and to the left in rad/s, to be told before a picture is taken.
    pub motion: [f64; 2],
}

impl Camera {
    /// A camera whose first exposure is still to come.
    pub fn new(config: &config::Camera, seed: u64) -> Self {
        let (width, height) = (config.width, config.height);
        let mut rays = Vec::with_capacity(width * height);
        let mut vignetting = Vec::with_capacity(width * height);
        let corner = ((width * width + height * height) as f64).sqrt() / 2.0;
        for v in 0..height {
            for u in 0..width {
                let (a, b) = undistort(
                    &config.lens,
                    (u as f64 - config.cx) / config.fx,
                    (v as f64 - config.cy) / config.fy,
                );
                let optical = [a, b, 1.0];
                rays.push(std::array::from_fn(|axis| {
                    (0..3).map(|k| config.rotation[axis][k] * optical[k]).sum()
                }));
                let radius = (u as f64 - config.cx).hypot(v as f64 - config.cy) / corner;
                vignetting.push((-config.vignetting * radius * radius) as f32);
            }
        }
        let mut camera = Self {
            config: config.clone(),
            random: Random::stream(seed, "camera"),
            rays,
            vignetting,
            pattern: Vec::new(),
            calibrations: 0,
            sequence: 0,
            next_exposure_us: config.first_exposure_us,
            last: Vec::new(),
            sensor: Sensor::new(&config.bolometer, width, height, seed),
            motion: [0.0; 2],
        };
        camera.draw_pattern();
        camera
    }

    /// Where the lens is.
    pub fn eye(&self, stance: Stance) -> Point {
        let config = &self.config;
        let mount = [config.mount_x, config.mount_y, config.mount_z];
        let [x, y, z] = turned(&stance.rotation(), &mount);
        [stance.pose.x + x, stance.pose.y + y, z]
    }

    /// Takes the picture that is due at `now_us`, if any: it may come to nothing, and it may come twice.
    pub fn poll(
        &mut self,
        now_us: u64,
        stance: Stance,
        terrain: &Terrain,
        fault: Option<CameraFault>,
    ) -> Vec<Frame> {
        if now_us < self.next_exposure_us {
            return Vec::new();
        }
        let exposure_us = self.next_exposure_us;
        self.next_exposure_us += self.config.period_us;
        self.sequence += 1;
        if fault == Some(CameraFault::Dead) {
            return Vec::new();
        }
        let (calibrations, regular) = self.shutter(exposure_us);
        let shut = self.sensor.shut(exposure_us, self.motion[1]);
        let calibrations = calibrations + self.sensor.calibrations;
        let ffc = regular || shut || fault == Some(CameraFault::Calibrating);
        let frozen = fault == Some(CameraFault::Frozen);
        if calibrations != self.calibrations {
            self.calibrations = calibrations;
            self.draw_pattern();
        }
        let mut depth = Vec::new();
        if !(ffc || frozen) || self.last.is_empty() {
            (self.last, depth) = self.expose(exposure_us, stance, terrain);
        }
        let times = self.sensor.deliver(exposure_us + self.config.latency_us);
        let frame = |delivered_us| Frame {
            sequence: self.sequence - 1,
            exposure_us: self.sensor.stamp(exposure_us),
            delivered_us,
            ffc,
            counts: self.last.clone(),
            stance,
            depth: depth.clone(),
        };
        times.into_iter().map(frame).collect()
    }

    /// How many calibrations have ended by `time_us`, and whether one is going on.
    fn shutter(&self, time_us: u64) -> (u64, bool) {
        let Some(since) = time_us.checked_sub(self.config.ffc_first_us) else {
            return (0, false);
        };
        let begun = since / self.config.ffc_period_us;
        let ffc = since % self.config.ffc_period_us < self.config.ffc_duration_us;
        (if ffc { begun } else { begun + 1 }, ffc)
    }

    /// A shutter calibration leaves a new residual pattern.
    fn draw_pattern(&mut self) {
        let (width, height) = (self.config.width, self.config.height);
        let random = &mut self.random;
        let mut draw = |count: usize, sigma: f64| -> Vec<f32> {
            (0..count)
                .map(|_| random.quick_normal() * sigma as f32)
                .collect()
        };
        let rows = draw(height, self.config.row_pattern);
        let columns = draw(width, self.config.column_pattern);
        self.pattern = draw(width * height, self.config.pixel_pattern);
        for (index, value) in self.pattern.iter_mut().enumerate() {
            *value += rows[index / width] + columns[index % width];
        }
    }

    fn expose(
        &mut self,
        exposure_us: u64,
        stance: Stance,
        terrain: &Terrain,
    ) -> (Vec<u16>, Vec<f32>) {
        let (mut scene, depth) = self.scene(stance, terrain);
        if self.sensor.is_slow() && self.motion != [0.0; 2] {
            scene = self.smear(&scene, &depth);
        }
        self.sensor.disturb(exposure_us, &mut scene);
        let netd = self.config.netd as f32;
        for (index, kelvin) in scene.iter_mut().enumerate() {
            *kelvin +=
                self.vignetting[index] + self.pattern[index] + netd * self.random.quick_normal();
        }
        let count = |kelvin: &f32| (kelvin * 100.0 + 0.5).clamp(0.0, 65_535.0) as i32 as u16;
        (scene.iter().map(count).collect(), depth)
    }

    /// What pixels that follow the scene with a time constant show while the rover moves: the scene of now at the
    /// places where they saw it a while ago, by Gauss-Laguerre quadrature over the exponential weights.
    fn smear(&self, scene: &[f32], depth: &[f32]) -> Vec<f32> {
        const NODES: [(f64, f64); 3] = [
            (0.415_775, 0.711_093),
            (2.294_280, 0.278_518),
            (6.289_945, 0.010_389),
        ];
        let config = &self.config;
        let mut smeared = vec![0.0_f32; scene.len()];
        for (node, weight) in NODES {
            let before = node * config.bolometer.time_constant;
            let (sine, cosine) = (self.motion[1] * before).sin_cos();
            let way = self.motion[0] * before;
            for (index, ray) in self.rays.iter().enumerate() {
                // What this pixel saw then, on base_link as it stood then and as it stands now: its depth is taken as
                // the present one.
                let far = f64::from(depth[index]).min(20.0);
                let (x, y) = (
                    config.mount_x + far * ray[0] - way,
                    config.mount_y + far * ray[1],
                );
                let base = [
                    cosine * x + sine * y - config.mount_x,
                    cosine * y - sine * x - config.mount_y,
                    far * ray[2],
                ];
                let kelvin = match self.project(base) {
                    Some((u, v)) => self.sample(scene, u, v),
                    None => scene[index],
                };
                smeared[index] += weight as f32 * kelvin;
            }
        }
        smeared
    }

    /// Pixel of a point given from the lens in base_link's axes; None behind it.
    fn project(&self, base: Point) -> Option<(f64, f64)> {
        project(&self.config, base).map(|(u, v, _)| (u, v))
    }

    /// Bilinear, drawn out at the edges.
    fn sample(&self, scene: &[f32], u: f64, v: f64) -> f32 {
        let (width, height) = (self.config.width, self.config.height);
        let u = u.clamp(0.0, width as f64 - 1.001);
        let v = v.clamp(0.0, height as f64 - 1.001);
        let (column, row) = (u as usize, v as usize);
        let (wu, wv) = ((u - column as f64) as f32, (v - row as f64) as f32);
        let at = row * width + column;
        let upper = scene[at] + wu * (scene[at + 1] - scene[at]);
        let lower = scene[at + width] + wu * (scene[at + width + 1] - scene[at + width]);
        upper + wv * (lower - upper)
    }

    /// What a perfect sensor would see from `stance`, row-major: temperatures in kelvin, and depths as in `Frame`.
    pub fn scene(&self, stance: Stance, terrain: &Terrain) -> (Vec<f32>, Vec<f32>) {
        let eye = self.eye(stance);
        let rotation = stance.rotation();
        let see = |ray: &Point| {
            // Rays are one long along the optical axis: the parameter of the hit is the depth.
            let (depth, kelvin) = terrain
                .look(eye, turned(&rotation, ray))
                .unwrap_or((f32::INFINITY, SKY_TEMPERATURE));
            (kelvin, depth)
        };
        self.rays.iter().map(see).unzip()
    }
}

/// Column, row and depth of a point given from the lens in base_link's axes; None behind it.
pub fn project(config: &config::Camera, base: Point) -> Option<(f64, f64, f64)> {
    let along = |k: usize| {
        (0..3)
            .map(|axis| config.rotation[axis][k] * base[axis])
            .sum::<f64>()
    };
    let range = along(2);
    if range <= 0.0 {
        return None;
    }
    if config.lens == [0.0; 5] {
        let u = config.fx * along(0) / range + config.cx;
        return Some((u, config.fy * along(1) / range + config.cy, range));
    }
    let (a, b) = (along(0) / range, along(1) / range);
    // Far outside the picture the polynomial turns back and would lay points into it.
    if a * a + b * b > FARTHEST_SQUARE {
        return None;
    }
    let (a, b) = distort(&config.lens, a, b);
    Some((config.fx * a + config.cx, config.fy * b + config.cy, range))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::attitude::Attitude;
    use crate::pose::Pose;

    const POSE: Stance = Stance {
        pose: Pose {
            x: 1.0,
            y: 1.0,
            heading: 0.0,
        },
        attitude: Attitude {
            roll: 0.0,
            pitch: 0.0,
        },
    };

    fn small() -> config::Camera {
        config::Camera {
            width: 16,
            height: 12,
            cx: 7.5,
            cy: 5.5,
            fx: 14.0,
            fy: 14.0,
            ..Default::default()
        }
    }

    fn ground() -> Terrain {
        Terrain::new(vec![300.0; 400], vec![0.0; 400], 20, (-10.0, -10.0), 1.0).unwrap()
    }

    #[test]
    fn pictures_come_at_their_period_with_their_own_time() {
        let mut camera = Camera::new(&small(), 1);
        let frames: Vec<Frame> = (0..600)
            .flat_map(|ms| camera.poll(ms * 1000, POSE, &ground(), None))
            .collect();
        let exposures: Vec<u64> = frames
            .iter()
            .map(|frame| frame.exposure_us / 1000)
            .collect();
        assert_eq!(exposures, [50, 170, 290, 410, 530]);
        assert!(frames
            .iter()
            .all(|frame| frame.delivered_us == frame.exposure_us + 60_000));
        assert_eq!(
            frames
                .iter()
                .map(|frame| frame.sequence)
                .collect::<Vec<_>>(),
            [0, 1, 2, 3, 4]
        );
    }

    #[test]
    fn an_even_ground_is_seen_at_its_temperature_up_to_noise_and_vignetting() {
        let mut camera = Camera::new(&small(), 1);
        let frame = camera.poll(50_000, POSE, &ground(), None).remove(0);
        for (pixel, depth) in frame.counts.iter().zip(&frame.depth) {
            assert!(depth.is_finite());
            assert!((29_900..=30_030).contains(pixel), "{pixel}");
        }
    }

    #[test]
    fn a_closed_shutter_repeats_the_last_picture_without_depths_and_leaves_a_new_pattern() {
        let config = config::Camera {
            netd: 0.0,
            ..small()
        };
        let mut camera = Camera::new(&config, 1);
        let frames: Vec<Frame> = (0..4000)
            .flat_map(|ms| camera.poll(ms * 1000, POSE, &ground(), None))
            .collect();
        let closed: Vec<bool> = frames.iter().map(|frame| frame.ffc).collect();
        let first = closed.iter().position(|ffc| *ffc).unwrap();
        let open = first + closed[first..].iter().position(|ffc| !*ffc).unwrap();
        assert!((3_000_000..3_120_000).contains(&frames[first].exposure_us));
        assert!(frames[open].exposure_us >= 3_400_000);
        let before = &frames[first - 1].counts;
        for frame in &frames[first..open] {
            assert!(frame.depth.is_empty() && frame.counts == *before);
        }
        assert_ne!(frames[open].counts, *before);
    }

    #[test]
    fn a_frozen_camera_repeats_itself_and_a_dead_one_is_silent() {
        let mut camera = Camera::new(&small(), 1);
        let first = camera.poll(50_000, POSE, &ground(), None).remove(0);
        let frozen = camera
            .poll(170_000, POSE, &ground(), Some(CameraFault::Frozen))
            .remove(0);
        assert_eq!(frozen.counts, first.counts);
        assert!(camera
            .poll(290_000, POSE, &ground(), Some(CameraFault::Dead))
            .is_empty());
    }
}
