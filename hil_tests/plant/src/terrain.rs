//! The ground as two rasters, height and temperature, and the rays that meet it.
//!
//! A ray is followed through square tiles whose greatest height is known: while the ray stays above a tile's greatest
//! height it is skipped in one step, only below it the ray advances by half a cell.

/// Cells along the side of a tile.
const TILE: usize = 8;
/// The finest step of a ray, in cells.
const STEP: f64 = 0.5;

pub struct Terrain {
    columns: usize,
    rows: usize,
    origin: (f64, f64),
    resolution: f64,
    temperature: Vec<f32>,
    height: Vec<f32>,
    tile_columns: usize,
    tile_rows: usize,
    tiles: Vec<f32>,
    highest: f64,
    lowest: f64,
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
            return Err("ground rasters: temperature and height must have one shape, at least 2 x 2 cells".into());
        }
        if let Some(index) = (0..height.len()).find(|&i| !(height[i].is_finite() && temperature[i].is_finite())) {
            return Err(format!("ground rasters: cell ({}, {}) is not finite", index % columns, index / columns));
        }
        let rows = height.len() / columns;
        let (tile_columns, tile_rows) = (columns.div_ceil(TILE), rows.div_ceil(TILE));
        let mut tiles = vec![f32::NEG_INFINITY; tile_columns * tile_rows];
        for tile_row in 0..tile_rows {
            for tile_column in 0..tile_columns {
                // One cell more on each side: bilinear interpolation at the rim reads the neighbours.
                let span = |tile: usize, size: usize| (tile * TILE).saturating_sub(1)..((tile + 1) * TILE + 1).min(size);
                let tile = &mut tiles[tile_row * tile_columns + tile_column];
                for row in span(tile_row, rows) {
                    let line = &height[row * columns..(row + 1) * columns];
                    *tile = line[span(tile_column, columns)].iter().fold(*tile, |max, h| max.max(*h));
                }
            }
        }
        let highest = f64::from(height.iter().fold(f32::NEG_INFINITY, |max, h| max.max(*h)));
        let lowest = f64::from(height.iter().fold(f32::INFINITY, |min, h| min.min(*h)));
        Ok(Self {
            columns,
            rows,
            origin,
            resolution,
            temperature,
            height,
            tile_columns,
            tile_rows,
            tiles,
            highest,
            lowest,
        })
    }

    /// Index of the upper-left of the four cells around (x, y) and the weights towards its neighbours.
    /// Beyond the rim the ground goes on as its outermost cells.
    fn locate(&self, x: f64, y: f64) -> (usize, f32, f32) {
        let column = ((x - self.origin.0) / self.resolution - 0.5).clamp(0.0, (self.columns - 1) as f64 - 1e-6);
        let row = ((y - self.origin.1) / self.resolution - 0.5).clamp(0.0, (self.rows - 1) as f64 - 1e-6);
        let (i, j) = (column as usize, row as usize);
        (j * self.columns + i, (column - i as f64) as f32, (row - j as f64) as f32)
    }

    fn sample(&self, raster: &[f32], x: f64, y: f64) -> f32 {
        let (index, wx, wy) = self.locate(x, y);
        let lower = raster[index] + wx * (raster[index + 1] - raster[index]);
        let above = index + self.columns;
        let upper = raster[above] + wx * (raster[above + 1] - raster[above]);
        lower + wy * (upper - lower)
    }

    /// Height at (x, y), metres, bilinear.
    pub fn height_at(&self, x: f64, y: f64) -> f64 {
        f64::from(self.sample(&self.height, x, y))
    }

    /// Temperature at (x, y), kelvin, bilinear.
    pub fn temperature_at(&self, x: f64, y: f64) -> f32 {
        self.sample(&self.temperature, x, y)
    }

    /// Where a ray from `eye` along `direction` (any length) first meets the ground; None when it goes to the sky.
    pub fn cast(&self, eye: Point, direction: Point) -> Option<(f64, f64)> {
        if direction[2] >= -1e-6 {
            return None;
        }
        let start = ((self.highest - eye[2]) / direction[2]).max(0.0);
        let end = ((self.lowest - eye[2]) / direction[2]).max(0.0);
        let hit = self.march(eye, direction, start, end).unwrap_or(end);
        Some((eye[0] + hit * direction[0], eye[1] + hit * direction[1]))
    }

    /// Whether the ground between `eye` and the ground point (x, y) hides that point.
    pub fn hidden(&self, eye: Point, x: f64, y: f64) -> bool {
        // The point lies a little above its cell, so that the cell does not hide itself.
        const LIFT: f64 = 0.003;
        let z = self.height_at(x, y) + LIFT;
        let direction = [x - eye[0], y - eye[1], z - eye[2]];
        if direction[2] >= 0.0 {
            return true;
        }
        let start = ((self.highest - eye[2]) / direction[2]).max(0.0);
        start < 1.0 && self.march(eye, direction, start, 1.0).is_some()
    }

    /// First parameter in [start, end] at which the ray is below the ground.
    fn march(&self, eye: Point, direction: Point, start: f64, end: f64) -> Option<f64> {
        let at = |t: f64| (eye[0] + t * direction[0], eye[1] + t * direction[1], eye[2] + t * direction[2]);
        let run = direction[0].hypot(direction[1]);
        let step = STEP * self.resolution / run.max(-direction[2]);
        let nudge = 1e-4 * step;
        let side = TILE as f64 * self.resolution;
        let mut t = start;
        let mut above = start;
        while t <= end {
            let (x, y, z) = at(t);
            let (top, leave) = self.tile(x, y, direction, side);
            let exit = (t + leave + nudge).min(end);
            if at(exit).2 > top {
                if exit >= end {
                    return None;
                }
                (t, above) = (exit, exit);
                continue;
            }
            if z > top {
                // Into the tile's reach, still above all of it.
                t += (top - z) / direction[2];
                above = t;
            }
            while t <= exit {
                let (x, y, z) = at(t);
                if z <= self.height_at(x, y) {
                    return Some(self.refine(eye, direction, above, t));
                }
                above = t;
                if t >= end {
                    return None;
                }
                t = (t + step).min(end);
            }
        }
        None
    }

    /// Greatest height of the tile at (x, y), and the ray parameter until the ray leaves it.
    fn tile(&self, x: f64, y: f64, direction: Point, side: f64) -> (f64, f64) {
        let (u, v) = ((x - self.origin.0) / side, (y - self.origin.1) / side);
        let column = u.floor().clamp(0.0, (self.tile_columns - 1) as f64);
        let row = v.floor().clamp(0.0, (self.tile_rows - 1) as f64);
        let top = f64::from(self.tiles[row as usize * self.tile_columns + column as usize]);
        let distance = |position: f64, slope: f64| {
            let whole = position.floor();
            if slope > 1e-12 {
                (whole + 1.0 - position) * side / slope
            } else if slope < -1e-12 {
                (whole - position) * side / slope
            } else {
                f64::INFINITY
            }
        };
        (top, distance(u, direction[0]).min(distance(v, direction[1])))
    }

    /// The crossing between `above` (above the ground) and `below`, by bisection to a fraction of a millimetre.
    fn refine(&self, eye: Point, direction: Point, mut above: f64, mut below: f64) -> f64 {
        for _ in 0..5 {
            let middle = 0.5 * (above + below);
            let (x, y) = (eye[0] + middle * direction[0], eye[1] + middle * direction[1]);
            if eye[2] + middle * direction[2] > self.height_at(x, y) {
                above = middle;
            } else {
                below = middle;
            }
        }
        0.5 * (above + below)
    }
}
