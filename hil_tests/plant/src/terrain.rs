//! The ground as two rasters, height and temperature, and the rays that meet it.
//!
//! A ray is followed in units of cells through square tiles whose greatest height is known: while the ray stays
//! above that height the tile is skipped in one step, only below it the ray advances cell by cell. This is the inner
//! loop of the renderer, hence single precision and no divisions.

use crate::tiles::{Ray, Tiles};

/// Height and temperature of the ground.
pub struct Terrain {
    columns: usize,
    origin: (f64, f64),
    /// Cells per metre.
    density: f64,
    temperature: Vec<f32>,
    height: Vec<f32>,
    last_column: f32,
    last_row: f32,
    tiles: Tiles,
    highest: f64,
    lowest: f64,
    /// The temperature at time zero, and what is added to it by the second; empty where nothing changes.
    base: Vec<f32>,
    layers: Vec<Layer>,
}

/// A part of the temperature that changes: kelvin by cell, times a factor by second.
struct Layer {
    raster: Vec<f32>,
    series: Vec<f64>,
}

/// A point in map coordinates, metres.
pub type Point = [f64; 3];

impl Terrain {
    /// Rasters are row-major, row 0 at the smallest y; cell (0, 0) has its lower-left corner at `origin`.
    pub fn new(
        temperature: Vec<f32>,
        height: Vec<f32>,
        columns: usize,
        origin: (f64, f64),
        resolution: f64,
    ) -> Result<Self, String> {
        if columns < 2 || height.len() < 2 * columns || temperature.len() != height.len() {
            return Err(
                "ground rasters: temperature and height must have one shape, at least 2 x 2 cells"
                    .into(),
            );
        }
        if let Some(index) =
            (0..height.len()).find(|&i| !(height[i].is_finite() && temperature[i].is_finite()))
        {
            return Err(format!(
                "ground rasters: cell ({}, {}) is not finite",
                index % columns,
                index / columns
            ));
        }
        let rows = height.len() / columns;
        let highest = f64::from(height.iter().fold(f32::NEG_INFINITY, |max, h| max.max(*h)));
        let lowest = f64::from(height.iter().fold(f32::INFINITY, |min, h| min.min(*h)));
        Ok(Self {
            columns,
            origin,
            density: 1.0 / resolution,
            temperature,
            // A hair less than the last centre: its right and upper neighbours are read too.
            last_column: (columns - 1) as f32 - 1e-3,
            last_row: (rows - 1) as f32 - 1e-3,
            tiles: Tiles::new(&height, columns),
            height,
            highest,
            lowest,
            base: Vec::new(),
            layers: Vec::new(),
        })
    }

    /// Lets a part of the temperature change: kelvin by cell, times `series` by second, whose last value stays.
    pub fn add_layer(&mut self, raster: Vec<f32>, series: Vec<f64>) -> Result<(), String> {
        if raster.len() != self.temperature.len() || series.is_empty() {
            return Err(
                "layer: its raster has the ground's shape, its series at least one value".into(),
            );
        }
        if self.layers.is_empty() {
            self.base = self.temperature.clone();
        }
        self.layers.push(Layer { raster, series });
        Ok(())
    }

    /// Brings the temperature to a second of the world.
    pub fn warm(&mut self, second: usize) {
        if self.layers.is_empty() {
            return;
        }
        self.temperature.copy_from_slice(&self.base);
        for layer in &self.layers {
            let factor = layer.series[second.min(layer.series.len() - 1)] as f32;
            if factor != 0.0 {
                for (kelvin, part) in self.temperature.iter_mut().zip(&layer.raster) {
                    *kelvin += factor * part;
                }
            }
        }
    }

    /// Greatest height anywhere, metres.
    pub fn highest(&self) -> f64 {
        self.highest
    }

    /// Least height anywhere, metres.
    pub fn lowest(&self) -> f64 {
        self.lowest
    }

    /// Index of the lower-left of the four cells around (column, row), given in cells from the centre of cell (0, 0),
    /// and the weights towards its neighbours. Beyond the rim the ground goes on as its outermost cells.
    #[inline]
    fn locate(&self, column: f32, row: f32) -> (usize, f32, f32) {
        let column = column.max(0.0).min(self.last_column);
        let row = row.max(0.0).min(self.last_row);
        // Conversion to i32 truncates, which is floor here, and is much cheaper than to usize.
        let (i, j) = (column as i32, row as i32);
        let index = j as usize * self.columns + i as usize;
        (index, column - i as f32, row - j as f32)
    }

    #[inline]
    fn sample(&self, raster: &[f32], column: f32, row: f32) -> f32 {
        let (index, wx, wy) = self.locate(column, row);
        let above = index + self.columns;
        let lower = raster[index] + wx * (raster[index + 1] - raster[index]);
        let upper = raster[above] + wx * (raster[above + 1] - raster[above]);
        lower + wy * (upper - lower)
    }

    fn to_cells(&self, x: f64, y: f64) -> (f32, f32) {
        let column = (x - self.origin.0) * self.density - 0.5;
        let row = (y - self.origin.1) * self.density - 0.5;
        (column as f32, row as f32)
    }

    /// Height at (x, y), metres, bilinear.
    pub fn height_at(&self, x: f64, y: f64) -> f64 {
        let (column, row) = self.to_cells(x, y);
        f64::from(self.sample(&self.height, column, row))
    }

    /// Where a ray from `eye` along `direction` first meets the ground: in lengths of `direction`, and the
    /// temperature there in kelvin. None when it goes to the sky.
    pub fn look(&self, eye: Point, direction: Point) -> Option<(f32, f32)> {
        if direction[2] >= -1e-6 {
            return None;
        }
        let ray = self.ray(eye, direction);
        let end = ((self.lowest as f32 - ray.eye[2]) * ray.inverse[2]).max(0.0);
        let hit = self.march(&ray, self.entry(&ray), end).unwrap_or(end);
        let (column, row, _) = ray.at(hit);
        Some((hit, self.sample(&self.temperature, column, row)))
    }

    fn ray(&self, eye: Point, direction: Point) -> Ray {
        let (column, row) = self.to_cells(eye[0], eye[1]);
        let slope = [
            (direction[0] * self.density) as f32,
            (direction[1] * self.density) as f32,
            direction[2] as f32,
        ];
        Ray {
            eye: [column, row, eye[2] as f32],
            slope,
            inverse: slope.map(|s| 1.0 / s),
        }
    }

    /// Where the ray comes down to the highest ground.
    fn entry(&self, ray: &Ray) -> f32 {
        ((self.highest as f32 - ray.eye[2]) * ray.inverse[2]).max(0.0)
    }

    /// First parameter in [start, end] at which the descending ray is below the ground.
    fn march(&self, ray: &Ray, start: f32, end: f32) -> Option<f32> {
        let level = ray.slope[0].abs().max(ray.slope[1].abs());
        let step = 1.0 / level.max(-ray.slope[2] * self.density as f32);
        self.tiles
            .walk(ray, start, end, |from, to| self.search(ray, from, to, step))
    }

    /// The same in a part of the ray that is known to begin above the ground.
    #[inline]
    fn search(&self, ray: &Ray, from: f32, to: f32, step: f32) -> Option<f32> {
        let (mut t, mut above, mut room) = (from, from, 0.0);
        loop {
            let (column, row, z) = ray.at(t);
            let gap = z - self.sample(&self.height, column, row);
            if gap <= 0.0 {
                // The crossing between the last two points, both gaps taken as the ends of a line.
                return Some(above + (t - above) * room / (room - gap).max(1e-9));
            }
            if t >= to {
                return None;
            }
            (above, room) = (t, gap);
            t = (t + step).min(to);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    const COLUMNS: usize = 60;
    const CELL: f64 = 0.01;

    fn ground(height: impl Fn(usize, usize) -> f32) -> Terrain {
        let cells = (0..COLUMNS * COLUMNS).map(|i| (i % COLUMNS, i / COLUMNS));
        let heights = cells
            .clone()
            .map(|(column, row)| height(column, row))
            .collect();
        let kelvin = cells.map(|(column, _)| 290.0 + column as f32).collect();
        Terrain::new(kelvin, heights, COLUMNS, (0.0, 0.0), CELL).unwrap()
    }

    #[test]
    fn a_ray_meets_flat_ground_where_geometry_says_and_reads_its_temperature() {
        let flat = ground(|_, _| 0.0);
        let (length, kelvin) = flat.look([0.105, 0.3, 0.5], [0.4, 0.0, -1.0]).unwrap();
        assert!((length - 0.5).abs() < 1e-5);
        assert!((kelvin - 320.0).abs() < 1e-2, "column 30: {kelvin}");
        assert_eq!(
            flat.look([0.1, 0.3, 0.5], [1.0, 0.0, 0.0]),
            None,
            "a level ray goes to the sky"
        );
    }

    #[test]
    fn no_ray_goes_through_ground_that_a_fine_march_finds() {
        let mut random = Random::stream(1, "terrain");
        let rough =
            ground(|column, row| 0.02 * ((column as f32 / 5.0).sin() + (row as f32 / 7.0).cos()));
        for _ in 0..300 {
            let eye = [0.6 * random.uniform(), 0.6 * random.uniform(), 0.5];
            let direction = [random.symmetric(0.5), random.symmetric(0.5), -1.0];
            let (length, _) = rough.look(eye, direction).unwrap();
            let below = |t: f64| {
                eye[2] - t < rough.height_at(eye[0] + t * direction[0], eye[1] + t * direction[1])
            };
            let fine = (0..)
                .map(|i| f64::from(i) * 1e-4)
                .find(|t| below(*t))
                .unwrap();
            assert!(
                f64::from(length) < fine + 2e-3,
                "found {length}, first below at {fine}"
            );
            assert!(
                f64::from(length) > fine - 2e-3,
                "found {length}, first below at {fine}"
            );
        }
    }

    #[test]
    fn a_layer_changes_the_temperature_by_the_second_and_its_last_value_stays() {
        let mut flat = ground(|_, _| 0.0);
        let cells = COLUMNS * COLUMNS;
        assert!(flat.add_layer(vec![1.0; 3], vec![0.0]).is_err());
        flat.add_layer(vec![2.0; cells], vec![0.0, 0.5, 1.0])
            .unwrap();
        let kelvin = |flat: &Terrain| flat.look([0.105, 0.3, 0.5], [0.4, 0.0, -1.0]).unwrap().1;
        let before = kelvin(&flat);
        for (second, warmer) in [(1, 1.0), (2, 2.0), (9, 2.0), (0, 0.0)] {
            flat.warm(second);
            assert!((kelvin(&flat) - before - warmer).abs() < 1e-3);
        }
    }

    #[test]
    fn rasters_that_do_not_fit_are_refused() {
        let error = |kelvin: Vec<f32>, heights: Vec<f32>| {
            Terrain::new(kelvin, heights, 2, (0.0, 0.0), CELL)
                .err()
                .unwrap()
        };
        assert!(error(vec![0.0; 4], vec![0.0; 6]).contains("one shape"));
        assert!(error(vec![0.0, 0.0, f32::NAN, 0.0], vec![0.0; 4]).contains("cell (0, 1)"));
    }
}
