//! A grid of blocked cells. A cell is a full square of ground: the sweep is checked against squares, not centres.

use std::sync::OnceLock;

use crate::geometry::{distance, point_segment_squared, Point};
use crate::map::capsule::Capsule;
use crate::map::clearance_tiles::{Cells, Tiles};
use crate::map::distance_transform;
use crate::map::field::TOUCH_M;
use crate::map::square::{self, all_free};

/// Stands for the clearance of a map with nothing in it, in metres.
const FAR_M: f32 = 1e9;
/// A little more than half the diagonal of a cell, in cells.
const HALF_DIAGONAL_CELLS: f64 = 0.7072;
/// Cells by which a point may be off a cell's centre and still count as it; also the slack of a column's number.
pub(super) const OFF_CENTRE_CELLS: f64 = 1e-6;

/// Blocked cells, row 0 at the origin's y.
pub struct Grid {
    pub(super) columns: usize,
    pub(super) rows: usize,
    pub(super) resolution: f64,
    pub(super) origin: Point,
    pub(super) blocked: Vec<u8>,
    /// Clearance near obstacles, in cells.
    near: Tiles,
    /// Clearance however far, in metres; only computed when somebody asks for what the tiles do not know.
    far: OnceLock<Vec<f32>>,
}

impl Grid {
    /// `blocked`: row-major, not 0 is blocked; `resolution`: metres per cell; `origin`: lower-left corner.
    pub fn new(
        blocked: Vec<u8>,
        columns: usize,
        rows: usize,
        resolution: f64,
        origin: Point,
    ) -> Self {
        Self {
            columns,
            rows,
            resolution,
            origin,
            blocked,
            near: Tiles::new(columns, rows),
            far: OnceLock::new(),
        }
    }

    /// Distance in metres from every cell's centre to the nearest blocked square.
    pub fn clearance_map(&self) -> &[f32] {
        self.far.get_or_init(|| {
            let mut clearance =
                distance_transform::clearance(&self.blocked, self.columns, self.rows);
            for value in &mut clearance {
                *value = (*value * self.resolution as f32).min(FAR_M);
            }
            clearance
        })
    }

    /// Clearance of a cell's centre in cells, as far as the tiles know it.
    pub(super) fn near(&self, column: usize, row: usize) -> f32 {
        let cells = Cells {
            blocked: &self.blocked,
            columns: self.columns,
            rows: self.rows,
        };
        self.near.clearance(&cells, column, row)
    }

    /// Clearance of a cell's centre in metres, exact.
    pub(super) fn exact(&self, column: usize, row: usize) -> f64 {
        let near = self.near(column, row);
        if near < Tiles::LIMIT {
            f64::from(near) * self.resolution
        } else {
            f64::from(self.clearance_map()[row * self.columns + column])
        }
    }

    /// True when the tiles tell what is nearer than `distance` from what is not.
    pub(super) fn tiles_suffice(&self, distance: f64) -> bool {
        distance <= f64::from(Tiles::LIMIT - 1.0) * self.resolution
    }

    /// Column and row of the cell that holds `p`, clamped to the grid.
    pub(super) fn cell(&self, p: Point) -> (usize, usize) {
        let column = ((p.x - self.origin.x) / self.resolution).max(0.0) as usize;
        let row = ((p.y - self.origin.y) / self.resolution).max(0.0) as usize;
        (column.min(self.columns - 1), row.min(self.rows - 1))
    }

    pub(super) fn centre(&self, column: usize, row: usize) -> Point {
        Point::new(
            self.origin.x + (column as f64 + 0.5) * self.resolution,
            self.origin.y + (row as f64 + 0.5) * self.resolution,
        )
    }

    /// The clearance of the centre of `p`'s cell (a lower bound where it is far), and how far `p` is from there.
    pub(super) fn cell_clearance(&self, p: Point, near: bool) -> (f64, f64) {
        let (column, row) = self.cell(p);
        let clearance = if near {
            f64::from(self.near(column, row)) * self.resolution
        } else {
            self.exact(column, row)
        };
        (clearance, distance(p, self.centre(column, row)))
    }

    /// Exact: no blocked square lies nearer than `radius` to the segment.
    pub(super) fn squares_clear(&self, a: Point, b: Point, radius: f64) -> bool {
        let (left, bottom) = self.cell(Point::new(a.x.min(b.x) - radius, a.y.min(b.y) - radius));
        let (right, top) = self.cell(Point::new(a.x.max(b.x) + radius, a.y.max(b.y) + radius));
        let reach = (radius - TOUCH_M).max(0.0);
        // A square lies between two discs around its centre: mostly one of them tells.
        let (inner, outer) = (
            reach - TOUCH_M,
            reach + HALF_DIAGONAL_CELLS * self.resolution + TOUCH_M,
        );
        let capsule = Capsule::new(a, b);
        let low = Point::new(
            self.origin.x + 0.5 * self.resolution,
            self.origin.y + 0.5 * self.resolution,
        );
        let per_cell = 1.0 / self.resolution;
        let mut y = low.y + bottom as f64 * self.resolution;
        for row in bottom..=top {
            let middle_line = y;
            y += self.resolution;
            let first = row * self.columns;
            if right - left < square::MAX_WORDS_CELLS
                && all_free(&self.blocked[first + left..=first + right])
            {
                continue;
            }
            // Columns of the cells whose centres are near, a little generously.
            let (from, to) = capsule.span(middle_line, outer);
            let from = ((from - low.x) * per_cell + (1.0 - OFF_CENTRE_CELLS)).max(left as f64)
                as i32 as usize;
            let to = ((to - low.x) * per_cell + OFF_CENTRE_CELLS).min(right as f64);
            if to < from as i32 as f64 {
                continue;
            }
            let line = &self.blocked[first + from..=first + to as i32 as usize];
            if all_free(line) {
                continue;
            }
            for (offset, &cell) in line.iter().enumerate() {
                if cell != 0 {
                    let column = from + offset;
                    let middle = point_segment_squared(self.centre(column, row), a, b);
                    if inner > 0.0 && middle < inner * inner {
                        return false;
                    }
                    if middle > outer * outer {
                        continue;
                    }
                    let squared = self.square_distance_squared(column, row, a, b);
                    // Never through the crack between two squares that share a corner, however thin the robot.
                    if squared < reach * reach || squared <= TOUCH_M * TOUCH_M {
                        return false;
                    }
                }
            }
        }
        true
    }

    /// Squared distance between a cell's square and the segment `a`–`b`.
    pub(super) fn square_distance_squared(
        &self,
        column: usize,
        row: usize,
        a: Point,
        b: Point,
    ) -> f64 {
        let low = Point::new(
            self.origin.x + column as f64 * self.resolution,
            self.origin.y + row as f64 * self.resolution,
        );
        let high = Point::new(low.x + self.resolution, low.y + self.resolution);
        square::distance_squared(low, high, a, b)
    }
}
