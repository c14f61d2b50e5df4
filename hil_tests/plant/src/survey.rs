//! Which ground the camera has really seen: 1 cm cells, marked from the true pose at the true exposure.

use crate::attitude::{turned, turned_back, Stance};
use crate::camera::project;
use crate::config;
use crate::lens::undistort;
use crate::terrain::{Point, Terrain};

/// Side of a cell, metres.
pub const CELL: f64 = 0.01;
/// The raster reaches this far beyond the area, metres.
const MARGIN: f64 = 0.5;
/// Ground farther away than this from the camera is not counted as seen, metres.
const FARTHEST: f64 = 6.0;

/// A cell this much deeper than the pixel's ray went still counts as hit: a pixel covers up to 2 cm of ground, metres.
const DEPTH_TOLERANCE: f64 = 0.02;

/// Raster of the area with a margin around it.
pub struct Survey {
    camera: config::Camera,
    area: (f64, f64),
    columns: usize,
    rows: usize,
    seen: Vec<bool>,
    /// Cells that a wheel has touched unseen: each counts once.
    touched: Vec<bool>,
    touched_cells: u64,
}

impl Survey {
    /// Nothing seen but the surveyed disc around the launch.
    pub fn new(config: &config::Config) -> Self {
        let cells = |size: f64| ((size + 2.0 * MARGIN) / CELL).ceil() as usize;
        let (columns, rows) = (cells(config.area_width), cells(config.area_height));
        let mut survey = Self {
            camera: config.camera.clone(),
            area: (config.area_width, config.area_height),
            columns,
            rows,
            seen: vec![false; columns * rows],
            touched: vec![false; columns * rows],
            touched_cells: 0,
        };
        let launch = &config.launch;
        let r = launch.surveyed_radius;
        let (low, high) = ([launch.x - r, launch.y - r], [launch.x + r, launch.y + r]);
        survey.for_cells(low, high, |survey, index, x, y| {
            survey.seen[index] |= (x - launch.x).hypot(y - launch.y) <= r;
        });
        survey
    }

    /// Columns, rows, and x and y of the raster's lower-left corner.
    pub fn shape(&self) -> (usize, usize, f64, f64) {
        (self.columns, self.rows, -MARGIN, -MARGIN)
    }

    /// Cells, row-major, row 0 at the smallest y.
    pub fn seen(&self) -> &[bool] {
        &self.seen
    }

    /// Ground that was seen before, of the same raster; false when it does not fit.
    pub fn add_seen(&mut self, seen: &[bool]) -> bool {
        let fits = seen.len() == self.seen.len();
        for (cell, before) in self.seen.iter_mut().zip(seen).filter(|_| fits) {
            *cell |= before;
        }
        fits
    }

    /// Area that a wheel touched before it was seen, m².
    pub fn unseen_touched(&self) -> f64 {
        self.touched_cells as f64 * CELL * CELL
    }

    /// Share of the area that has been seen, 0 to 1.
    pub fn seen_share(&self) -> f64 {
        let (mut seen, mut all) = (0_u64, 0_u64);
        for row in 0..self.rows {
            for column in 0..self.columns {
                let (x, y) = centre(column, row);
                if x > 0.0 && y > 0.0 && x < self.area.0 && y < self.area.1 {
                    all += 1;
                    seen += u64::from(self.seen[row * self.columns + column]);
                }
            }
        }
        seen as f64 / all.max(1) as f64
    }

    /// Marks every cell that lies in the picture taken from `stance` and is not behind what the pixel's ray has hit.
    /// `depth`: of every pixel, see `camera::Frame`.
    pub fn mark(&mut self, eye: Point, stance: Stance, depth: &[f32], terrain: &Terrain) {
        let rotation = stance.rotation();
        let (low, high) = self.reach(eye, &rotation, terrain);
        let camera = self.camera.clone();
        let (width, height) = (camera.width as f64, camera.height as f64);
        self.for_cells(low, high, |survey, index, x, y| {
            if survey.seen[index] {
                return;
            }
            let z = terrain.height_at(x, y);
            let base = turned_back(&rotation, &[x - eye[0], y - eye[1], z - eye[2]]);
            let Some((u, v, range)) = project(&camera, base) else {
                return;
            };
            let (u, v) = (u + 0.5, v + 0.5);
            if u >= 0.0 && v >= 0.0 && u < width && v < height {
                let pixel = v as usize * camera.width + u as usize;
                survey.seen[index] = range <= f64::from(depth[pixel]) + DEPTH_TOLERANCE;
            }
        });
    }

    /// Counts the cells under a contact patch that were not seen yet; `covers` tells whether a point is under it.
    pub fn touch(&mut self, low: [f64; 2], high: [f64; 2], covers: impl Fn(f64, f64) -> bool) {
        self.for_cells(low, high, |survey, index, x, y| {
            if !survey.seen[index] && !survey.touched[index] && covers(x, y) {
                survey.touched[index] = true;
                survey.touched_cells += 1;
            }
        });
    }

    /// Bounding box of the ground that the picture's corners can meet, at the lowest and at the highest ground.
    fn reach(&self, eye: Point, rotation: &[Point; 3], terrain: &Terrain) -> ([f64; 2], [f64; 2]) {
        let camera = &self.camera;
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for corner in 0..4 {
            let u = if corner & 1 == 0 {
                -0.5
            } else {
                camera.width as f64 - 0.5
            };
            let v = if corner & 2 == 0 {
                -0.5
            } else {
                camera.height as f64 - 0.5
            };
            let (a, b) = undistort(
                &camera.lens,
                (u - camera.cx) / camera.fx,
                (v - camera.cy) / camera.fy,
            );
            let optical = [a, b, 1.0];
            let base: Point = std::array::from_fn(|axis| {
                (0..3).map(|k| camera.rotation[axis][k] * optical[k]).sum()
            });
            let ahead = turned(rotation, &base);
            let level = ahead[0].hypot(ahead[1]).max(1e-9);
            for ground in [terrain.lowest(), terrain.highest()] {
                let drop = if ahead[2] < -1e-3 {
                    (ground - eye[2]) / ahead[2]
                } else {
                    f64::INFINITY
                };
                let t = drop.clamp(0.0, FARTHEST / level);
                for axis in 0..2 {
                    low[axis] = low[axis].min(eye[axis] + t * ahead[axis]);
                    high[axis] = high[axis].max(eye[axis] + t * ahead[axis]);
                }
            }
        }
        (low, high)
    }

    /// Calls `visit(self, index, x, y)` for the cells whose centres can lie in the box.
    fn for_cells(
        &mut self,
        low: [f64; 2],
        high: [f64; 2],
        mut visit: impl FnMut(&mut Self, usize, f64, f64),
    ) {
        let cell =
            |value: f64, size: usize| ((value + MARGIN) / CELL).clamp(0.0, size as f64) as usize;
        let (first_column, last_column) = (
            cell(low[0], self.columns),
            cell(high[0] + CELL, self.columns),
        );
        let (first_row, last_row) = (cell(low[1], self.rows), cell(high[1] + CELL, self.rows));
        for row in first_row..last_row {
            for column in first_column..last_column {
                let (x, y) = centre(column, row);
                visit(self, row * self.columns + column, x, y);
            }
        }
    }
}

fn centre(column: usize, row: usize) -> (f64, f64) {
    (
        (column as f64 + 0.5) * CELL - MARGIN,
        (row as f64 + 0.5) * CELL - MARGIN,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pose::Pose;

    fn survey() -> Survey {
        Survey::new(&config::Config {
            area_width: 1.0,
            area_height: 1.0,
            ..Default::default()
        })
    }

    #[test]
    fn the_launch_disc_counts_as_seen_and_nothing_else_at_first() {
        let survey = survey();
        let seen = survey.seen().iter().filter(|cell| **cell).count() as f64 * CELL * CELL;
        let radius = config::Launch::default().surveyed_radius;
        assert!(
            (seen - std::f64::consts::PI * radius * radius).abs() < 0.004,
            "{seen}"
        );
    }

    #[test]
    fn unseen_ground_counts_once_and_seen_ground_not_at_all() {
        let mut survey = survey();
        let patch =
            |survey: &mut Survey, x: f64| survey.touch([x, 0.9], [x + 0.05, 0.95], |_, _| true);
        patch(&mut survey, 0.9);
        let first = survey.unseen_touched();
        assert!(first > 0.002);
        patch(&mut survey, 0.9);
        assert_eq!(survey.unseen_touched(), first);
        survey.touch([0.35, 0.35], [0.45, 0.45], |_, _| true);
        assert_eq!(survey.unseen_touched(), first, "inside the launch disc");
    }

    #[test]
    fn a_picture_of_flat_ground_marks_what_lies_in_it_and_what_hides_it_does_not() {
        let camera = config::Config::default().camera;
        let flat = Terrain::new(vec![290.0; 400], vec![0.0; 400], 20, (-5.0, -5.0), 0.5).unwrap();
        let pose = Pose {
            x: 0.4,
            y: 0.4,
            heading: 0.3,
        };
        let eye = [pose.x, pose.y, camera.mount_z];
        let mut survey = survey();
        let before = survey.seen_share();
        survey.mark(
            eye,
            Stance::level(pose),
            &vec![0.1; camera.width * camera.height],
            &flat,
        );
        assert_eq!(
            survey.seen_share(),
            before,
            "something stands before the lens"
        );
        survey.mark(
            eye,
            Stance::level(pose),
            &vec![10.0; camera.width * camera.height],
            &flat,
        );
        assert!(survey.seen_share() > before + 0.1);
    }

    #[test]
    fn ground_of_another_area_is_refused() {
        let mut survey = survey();
        let all = vec![true; survey.seen().len()];
        assert!(!survey.add_seen(&all[1..]));
        assert!(survey.add_seen(&all));
        assert_eq!(survey.seen_share(), 1.0);
    }
}
