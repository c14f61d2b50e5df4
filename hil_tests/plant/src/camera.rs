//! The thermal camera: rays through the lens to the ground, and what the sensor makes of their temperatures.

use crate::attitude::{turned, Stance};
use crate::config;
use crate::faults::CameraFault;
use crate::random::Random;
use crate::terrain::{Point, Terrain};

/// What a ray that meets no ground sees, kelvin.
const SKY_TEMPERATURE: f32 = 250.0;

/// One picture on its way to the companion.
pub struct Frame {
    /// Number of the frame, from 0; counts on over frames that were not sent.
    pub sequence: u64,
    /// Time of the exposure, µs.
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
                let optical = [
                    (u as f64 - config.cx) / config.fx,
                    (v as f64 - config.cy) / config.fy,
                    1.0,
                ];
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

    /// Takes the picture that is due at `now_us`, if any.
    pub fn poll(
        &mut self,
        now_us: u64,
        stance: Stance,
        terrain: &Terrain,
        fault: Option<CameraFault>,
    ) -> Option<Frame> {
        if now_us < self.next_exposure_us {
            return None;
        }
        let exposure_us = self.next_exposure_us;
        self.next_exposure_us += self.config.period_us;
        self.sequence += 1;
        if fault == Some(CameraFault::Dead) {
            return None;
        }
        let (calibrations, regular) = self.shutter(exposure_us);
        let ffc = regular || fault == Some(CameraFault::Calibrating);
        let frozen = fault == Some(CameraFault::Frozen);
        if calibrations != self.calibrations {
            self.calibrations = calibrations;
            self.draw_pattern();
        }
        let mut depth = Vec::new();
        if !(ffc || frozen) || self.last.is_empty() {
            (self.last, depth) = self.expose(stance, terrain);
        }
        Some(Frame {
            sequence: self.sequence - 1,
            exposure_us,
            delivered_us: exposure_us + self.config.latency_us,
            ffc,
            counts: self.last.clone(),
            stance,
            depth,
        })
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

    fn expose(&mut self, stance: Stance, terrain: &Terrain) -> (Vec<u16>, Vec<f32>) {
        let (mut scene, depth) = self.scene(stance, terrain);
        let netd = self.config.netd as f32;
        for (index, kelvin) in scene.iter_mut().enumerate() {
            *kelvin +=
                self.vignetting[index] + self.pattern[index] + netd * self.random.quick_normal();
        }
        let count = |kelvin: &f32| (kelvin * 100.0 + 0.5).clamp(0.0, 65_535.0) as i32 as u16;
        (scene.iter().map(count).collect(), depth)
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
            .filter_map(|ms| camera.poll(ms * 1000, POSE, &ground(), None))
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
        let frame = camera.poll(50_000, POSE, &ground(), None).unwrap();
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
            .filter_map(|ms| camera.poll(ms * 1000, POSE, &ground(), None))
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
        let first = camera.poll(50_000, POSE, &ground(), None).unwrap();
        let frozen = camera
            .poll(170_000, POSE, &ground(), Some(CameraFault::Frozen))
            .unwrap();
        assert_eq!(frozen.counts, first.counts);
        assert!(camera
            .poll(290_000, POSE, &ground(), Some(CameraFault::Dead))
            .is_none());
    }
}
