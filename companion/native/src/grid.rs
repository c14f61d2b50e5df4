//! A grid of blocked cells. A cell is a full square of ground: the sweep is checked against squares, not centres.

use std::sync::OnceLock;

use crate::capsule::Capsule;
use crate::field::{wall_distance, Field, TOUCH};
use crate::geometry::{distance, point_segment_squared, Point};
use crate::tiles::{Cells, Tiles};
use crate::transform;

/// Stands for the clearance of a map with nothing in it.
const FAR: f32 = 1e9;
/// Cells of the coarsest lattice, about.
const COARSE_CELLS: f64 = 300_000.0;
/// A map of fewer cells is searched as it is.
const SMALL_CELLS: f64 = 60_000.0;

/// Cells that an edge and the disc may be long for all squares around it to be looked at, which asks for no clearance.
const SHORT: f64 = 8.0;

/// Cells of an edge whose squares are looked at together.
const PIECE: f64 = 32.0;

pub struct Grid {
    pub columns: usize,
    pub rows: usize,
    pub resolution: f64,
    pub origin: Point,
    pub blocked: Vec<u8>,
    /// Clearance near obstacles, in cells.
    near: Tiles,
    /// Clearance however far, in metres; only made when somebody asks for what the tiles do not know.
    far: OnceLock<Vec<f32>>,
}

impl Grid {
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
            let mut clearance = transform::clearance(&self.blocked, self.columns, self.rows);
            for value in &mut clearance {
                *value = (*value * self.resolution as f32).min(FAR);
            }
            clearance
        })
    }

    /// Clearance of a cell's centre in cells, as far as the tiles know it.
    fn near(&self, column: usize, row: usize) -> f32 {
        let cells = Cells {
            blocked: &self.blocked,
            columns: self.columns,
            rows: self.rows,
        };
        self.near.clearance(&cells, column, row)
    }

    /// Clearance of a cell's centre in metres, exact.
    fn exact(&self, column: usize, row: usize) -> f64 {
        let near = self.near(column, row);
        if near < Tiles::LIMIT {
            f64::from(near) * self.resolution
        } else {
            f64::from(self.clearance_map()[row * self.columns + column])
        }
    }

    /// True when the tiles tell what is nearer than `distance` from what is not.
    fn tiles_suffice(&self, distance: f64) -> bool {
        distance <= f64::from(Tiles::LIMIT - 1.0) * self.resolution
    }

    /// Column and row of the cell that holds `p`, clamped to the grid.
    fn cell(&self, p: Point) -> (usize, usize) {
        let column = ((p.x - self.origin.x) / self.resolution).max(0.0) as usize;
        let row = ((p.y - self.origin.y) / self.resolution).max(0.0) as usize;
        (column.min(self.columns - 1), row.min(self.rows - 1))
    }

    fn centre(&self, column: usize, row: usize) -> Point {
        Point::new(
            self.origin.x + (column as f64 + 0.5) * self.resolution,
            self.origin.y + (row as f64 + 0.5) * self.resolution,
        )
    }

    /// The clearance of the centre of `p`'s cell (a lower bound where it is far), and how far `p` is from there.
    fn cell_clearance(&self, p: Point, near: bool) -> (f64, f64) {
        let (column, row) = self.cell(p);
        let clearance = if near {
            f64::from(self.near(column, row)) * self.resolution
        } else {
            self.exact(column, row)
        };
        (clearance, distance(p, self.centre(column, row)))
    }

    /// Exact: no blocked square lies nearer than `radius` to the segment.
    fn squares_clear(&self, a: Point, b: Point, radius: f64) -> bool {
        let (left, bottom) = self.cell(Point::new(a.x.min(b.x) - radius, a.y.min(b.y) - radius));
        let (right, top) = self.cell(Point::new(a.x.max(b.x) + radius, a.y.max(b.y) + radius));
        let reach = (radius - TOUCH).max(0.0);
        // A square lies between two discs around its centre: mostly one of them tells.
        let (inner, outer) = (reach - TOUCH, reach + 0.7072 * self.resolution + TOUCH);
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
            if right - left < 16 && empty(&self.blocked[first + left..=first + right]) {
                continue;
            }
            // Columns of the cells whose centres are near, a little generously.
            let (from, to) = capsule.span(middle_line, outer);
            let from = ((from - low.x) * per_cell + (1.0 - 1e-6)).max(left as f64) as i32 as usize;
            let to = ((to - low.x) * per_cell + 1e-6).min(right as f64);
            if to < from as i32 as f64 {
                continue;
            }
            let line = &self.blocked[first + from..=first + to as i32 as usize];
            if empty(line) {
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
                    if squared < reach * reach || squared <= TOUCH * TOUCH {
                        return false;
                    }
                }
            }
        }
        true
    }

    /// Squared distance between a cell's square and the segment `a`–`b`.
    fn square_distance_squared(&self, column: usize, row: usize, a: Point, b: Point) -> f64 {
        let low = Point::new(
            self.origin.x + column as f64 * self.resolution,
            self.origin.y + row as f64 * self.resolution,
        );
        let high = Point::new(low.x + self.resolution, low.y + self.resolution);
        if crosses(a, b, low, high) {
            return 0.0;
        }
        let to_square = |p: Point| {
            let dx = (low.x - p.x).max(p.x - high.x).max(0.0);
            let dy = (low.y - p.y).max(p.y - high.y).max(0.0);
            dx * dx + dy * dy
        };
        [
            low,
            Point::new(high.x, low.y),
            high,
            Point::new(low.x, high.y),
        ]
        .iter()
        .map(|&corner| point_segment_squared(corner, a, b))
        .fold(to_square(a).min(to_square(b)), f64::min)
    }
}

/// True when none of the cells is blocked; eight at a time.
fn empty(line: &[u8]) -> bool {
    let word = |bytes: &[u8; 8]| u64::from_ne_bytes(*bytes);
    if let (Some(first), Some(last)) = (line.first_chunk(), line.last_chunk()) {
        // Up to 16 cells are two words that may overlap.
        let between = line.len() > 16 && line[8..line.len() - 8].iter().any(|&cell| cell != 0);
        return word(first) | word(last) == 0 && !between;
    }
    line.iter().all(|&cell| cell == 0)
}

/// True when the segment meets the open box (slab test).
fn crosses(a: Point, b: Point, low: Point, high: Point) -> bool {
    let (mut enter, mut leave) = (0.0f64, 1.0f64);
    for (from, to, least, most) in [(a.x, b.x, low.x, high.x), (a.y, b.y, low.y, high.y)] {
        let step = to - from;
        if step == 0.0 {
            if from <= least || from >= most {
                return false;
            }
        } else {
            let (first, second) = ((least - from) / step, (most - from) / step);
            enter = enter.max(first.min(second));
            leave = leave.min(first.max(second));
        }
    }
    enter < leave
}

impl Field for Grid {
    fn bounds(&self) -> (Point, Point) {
        (
            self.origin,
            Point::new(
                self.origin.x + self.columns as f64 * self.resolution,
                self.origin.y + self.rows as f64 * self.resolution,
            ),
        )
    }

    /// Bilinear between the cells' centres, where it is exact; beside a blocked cell up to a quarter of a cell too much.
    fn clearance(&self, p: Point) -> f64 {
        let u =
            ((p.x - self.origin.x) / self.resolution - 0.5).clamp(0.0, (self.columns - 1) as f64);
        let v = ((p.y - self.origin.y) / self.resolution - 0.5).clamp(0.0, (self.rows - 1) as f64);
        let (column, row) = (u.floor() as usize, v.floor() as usize);
        let (next_column, next_row) = (
            (column + 1).min(self.columns - 1),
            (row + 1).min(self.rows - 1),
        );
        let at = |c: usize, r: usize| self.exact(c, r);
        let (fu, fv) = (u - column as f64, v - row as f64);
        let wall = wall_distance(self.bounds(), p);
        let below = at(column, row) * (1.0 - fu) + at(next_column, row) * fu;
        let above = at(column, next_row) * (1.0 - fu) + at(next_column, next_row) * fu;
        wall.min(below * (1.0 - fv) + above * fv)
    }

    fn clearance_at_least(&self, p: Point) -> f64 {
        let (clearance, offset) = self.cell_clearance(p, true);
        wall_distance(self.bounds(), p).min(clearance - offset)
    }

    /// For cells' centres also false in blocked cells: no part of them can hold a robot, however thin.
    fn may_hold(&self, p: Point, radius: f64) -> bool {
        let (column, row) = self.cell(p);
        if self.blocked[row * self.columns + column] != 0 {
            return false;
        }
        let (clearance, offset) = self.cell_clearance(p, self.tiles_suffice(radius));
        wall_distance(self.bounds(), p) >= radius && clearance + offset >= radius - TOUCH
    }

    /// A point of the edge with clearance c vouches for all that lies beside √(c² - r²) of the edge before and after
    /// it. The check strides from one to the next, looks at two cells' length of squares where that is too little, and
    /// ends with the disc at `b`: what lies beyond it is beside no point of the edge.
    fn sweep_clear(&self, a: Point, b: Point, radius: f64) -> bool {
        let length = distance(a, b);
        let near = self.tiles_suffice(radius);
        let at = |along: f64| {
            if along >= length {
                b
            } else {
                a.towards(b, along / length)
            }
        };
        let mut travelled = 0.0;
        loop {
            let p = at(travelled);
            let (clearance, offset) = self.cell_clearance(p, near);
            // 1e-5 covers the rounding of the stored f32.
            let slack = 1e-5 * (self.resolution + clearance);
            if clearance + offset + slack < radius - TOUCH {
                return false;
            }
            let least = clearance - offset - slack;
            let stride = (least * least - radius * radius).max(0.0).sqrt();
            if least > radius && (stride > 0.5 * self.resolution || travelled >= length) {
                if travelled >= length {
                    return true;
                }
                travelled = (travelled + stride).min(length);
            } else {
                let end = (travelled + 2.0 * self.resolution).min(length);
                if !self.squares_clear(p, at(end), radius) {
                    return false;
                }
                if end >= length {
                    return true;
                }
                travelled = end;
            }
        }
    }

    fn room(&self, p: Point, radius: f64) -> Option<f64> {
        let (column, row) = self.cell(p);
        let centre = self.centre(column, row);
        let off = (p.x - centre.x).abs() + (p.y - centre.y).abs();
        let near = f64::from(self.near(column, row)) * self.resolution;
        let slack = 1e-4 * self.resolution;
        let wall = wall_distance(self.bounds(), p);
        // At a cell's centre the clearance is known exactly.
        if off < slack && (near - radius).abs() > 2.0 * slack && self.tiles_suffice(radius) {
            return (near > radius && self.inside(p, radius)).then_some(wall.min(near - slack));
        }
        let least = wall.min(near - distance(p, centre));
        (least > radius || self.point_clear(p, radius)).then_some(least)
    }

    /// A hop along a row, a column or a diagonal leads from one cell's centre to the next: where all of them have room
    /// for the disc and for half a cell's way besides, no square needs a look.
    fn hop_clear(&self, a: Point, b: Point, radius: f64) -> bool {
        let ((column, row), (to_column, to_row)) = (self.cell(a), self.cell(b));
        let (across, up) = (to_column as i64 - column as i64, to_row as i64 - row as i64);
        let cells = across.abs().max(up.abs());
        let even = |by: i64| by == 0 || by.abs() == cells;
        let centred = |p: Point, c: usize, r: usize| distance(p, self.centre(c, r));
        let off = centred(a, column, row) + centred(b, to_column, to_row);
        if even(across) && even(up) && off < 1e-6 * self.resolution && self.tiles_suffice(radius) {
            let slanting = across != 0 && up != 0;
            let fits = radius / self.resolution;
            let roomy = (fits * fits + if slanting { 0.5 } else { 0.25 }).sqrt() + 1e-4;
            let mut sure = true;
            for step in 0..=cells {
                let at = |from: usize, sign: i64| (from as i64 + step * sign) as usize;
                let near = self.near(at(column, across.signum()), at(row, up.signum()));
                if f64::from(near) < fits - 1e-4 {
                    return false;
                }
                sure &= f64::from(near) >= roomy;
            }
            if sure {
                return true;
            }
        }
        self.short_clear(a, b, radius)
    }

    fn short_clear(&self, a: Point, b: Point, radius: f64) -> bool {
        if distance(a, b).max(radius) > SHORT * self.resolution {
            return self.segment_clear(a, b, radius);
        }
        self.inside(a, radius) && self.inside(b, radius) && self.squares_clear(a, b, radius)
    }

    /// Squares are looked at in pieces of the edge, so that a slanting one does not look at all around it.
    fn edge_clear(&self, a: Point, b: Point, radius: f64) -> bool {
        if radius > SHORT * self.resolution {
            return self.segment_clear(a, b, radius);
        }
        let pieces = (distance(a, b) / (PIECE * self.resolution)).ceil().max(1.0);
        let at = |piece: f64| a.towards(b, piece / pieces);
        self.inside(a, radius)
            && self.inside(b, radius)
            && (0..pieces as usize).all(|piece| {
                let piece = piece as f64;
                self.squares_clear(at(piece), at(piece + 1.0), radius)
            })
    }

    /// A large map is first searched with fewer cells, and any map in steps of the robot's radius: ways through open
    /// ground seldom need them all.
    fn lattice_spacings(&self, radius: f64) -> Vec<f64> {
        let cells = (self.columns * self.rows) as f64;
        let widest = (1.01 * radius / self.resolution).floor();
        // Odd numbers of cells: then the lattice's points are centres of cells, whose clearance is known exactly.
        let odd = |cells: f64| 2.0 * ((cells - 1.0) / 2.0).floor() + 1.0;
        let mut coarse = odd((cells / COARSE_CELLS).sqrt().max(widest));
        let mut spacings = Vec::new();
        while coarse >= 3.0 && cells > SMALL_CELLS {
            spacings.push(coarse * self.resolution);
            coarse = odd(coarse / 3.0);
        }
        spacings.push(self.resolution);
        spacings
    }
}
