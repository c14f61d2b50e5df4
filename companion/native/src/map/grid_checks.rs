//! A grid as a planner asks it: checks of edges, cheap ones first, and the spacings of its lattices.

use crate::geometry::{distance, Point};
use crate::map::field::{wall_distance, Field, TOUCH_M};
use crate::map::grid::{Grid, OFF_CENTRE_CELLS};

/// Cells of the coarsest lattice, about.
const COARSE_CELLS: f64 = 300_000.0;
/// A map of fewer cells is searched as it is.
const MIN_COARSENED_CELLS: f64 = 60_000.0;
/// Spacing of the coarsest lattice of a small map in robot radii, a little over 1 so that 1 is not rounded down.
const COARSE_RADII: f64 = 1.01;
/// From each lattice to the next finer one.
const REFINEMENT: f64 = 3.0;
/// Cells that an edge and the disc's radius may be long for its squares to be looked at without asking for clearance.
const MAX_SHORT_CELLS: f64 = 8.0;
/// Cells of an edge whose squares are looked at together.
const PIECE_CELLS: f64 = 32.0;
/// Cells that the sweep goes on by where clearance is too little to tell.
const SWEEP_CELLS: f64 = 2.0;
/// Share of a clearance that covers the rounding of the stored f32.
const ROUNDING: f64 = 1e-5;
/// The same for clearances of cells' centres within the tiles' reach, in cells.
const CENTRE_ROUNDING_CELLS: f64 = 1e-4;

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
        wall_distance(self.bounds(), p) >= radius && clearance + offset >= radius - TOUCH_M
    }

    /// Where a point of the edge has clearance c, the disc touches nothing within √(c² − r²) before and after it. The
    /// check strides from one such point to the next, looks at two cells' length of squares where the stride would be
    /// too short, and ends with the disc at `b`.
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
            let slack = ROUNDING * (self.resolution + clearance);
            if clearance + offset + slack < radius - TOUCH_M {
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
                let end = (travelled + SWEEP_CELLS * self.resolution).min(length);
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

    fn free_clearance(&self, p: Point, radius: f64) -> Option<f64> {
        let (column, row) = self.cell(p);
        let centre = self.centre(column, row);
        let off = (p.x - centre.x).abs() + (p.y - centre.y).abs();
        let near = f64::from(self.near(column, row)) * self.resolution;
        let slack = CENTRE_ROUNDING_CELLS * self.resolution;
        let wall = wall_distance(self.bounds(), p);
        // At a cell's centre the clearance is known exactly.
        if off < slack && (near - radius).abs() > 2.0 * slack && self.tiles_suffice(radius) {
            return (near > radius && self.inside(p, radius)).then_some(wall.min(near - slack));
        }
        let least = wall.min(near - distance(p, centre));
        (least > radius || self.point_clear(p, radius)).then_some(least)
    }

    /// An edge along a row, a column or a diagonal passes through cells' centres: where each of them has clearance for
    /// the disc and for half the way to the next, no square needs a look.
    fn hop_clear(&self, a: Point, b: Point, radius: f64) -> bool {
        let ((column, row), (to_column, to_row)) = (self.cell(a), self.cell(b));
        let (across, up) = (to_column as i64 - column as i64, to_row as i64 - row as i64);
        let cells = across.abs().max(up.abs());
        let even = |by: i64| by == 0 || by.abs() == cells;
        let centred = |p: Point, c: usize, r: usize| distance(p, self.centre(c, r));
        let off = centred(a, column, row) + centred(b, to_column, to_row);
        if even(across)
            && even(up)
            && off < OFF_CENTRE_CELLS * self.resolution
            && self.tiles_suffice(radius)
        {
            let slanting = across != 0 && up != 0;
            let fits = radius / self.resolution;
            let ample =
                (fits * fits + if slanting { 0.5 } else { 0.25 }).sqrt() + CENTRE_ROUNDING_CELLS;
            let mut sure = true;
            for step in 0..=cells {
                let at = |from: usize, sign: i64| (from as i64 + step * sign) as usize;
                let near = self.near(at(column, across.signum()), at(row, up.signum()));
                if f64::from(near) < fits - CENTRE_ROUNDING_CELLS {
                    return false;
                }
                sure &= f64::from(near) >= ample;
            }
            if sure {
                return true;
            }
        }
        self.short_clear(a, b, radius)
    }

    fn short_clear(&self, a: Point, b: Point, radius: f64) -> bool {
        if distance(a, b).max(radius) > MAX_SHORT_CELLS * self.resolution {
            return self.segment_clear(a, b, radius);
        }
        self.inside(a, radius) && self.inside(b, radius) && self.squares_clear(a, b, radius)
    }

    /// Squares are looked at in pieces of the edge, so that a slanting one does not look at all around it.
    fn edge_clear(&self, a: Point, b: Point, radius: f64) -> bool {
        if radius > MAX_SHORT_CELLS * self.resolution {
            return self.segment_clear(a, b, radius);
        }
        let pieces = (distance(a, b) / (PIECE_CELLS * self.resolution))
            .ceil()
            .max(1.0);
        let at = |piece: f64| a.towards(b, piece / pieces);
        self.inside(a, radius)
            && self.inside(b, radius)
            && (0..pieces as usize).all(|piece| {
                let piece = piece as f64;
                self.squares_clear(at(piece), at(piece + 1.0), radius)
            })
    }

    /// A large map is first searched with fewer cells, and any map in steps of the robot's radius: paths over open ground
    /// seldom need them all.
    fn lattice_spacings(&self, radius: f64) -> Vec<f64> {
        let cells = (self.columns * self.rows) as f64;
        let widest = (COARSE_RADII * radius / self.resolution).floor();
        // Odd numbers of cells: then the lattice's points are centres of cells, whose clearance is known exactly.
        let odd = |cells: f64| 2.0 * ((cells - 1.0) / 2.0).floor() + 1.0;
        let mut coarse = odd((cells / COARSE_CELLS).sqrt().max(widest));
        let mut spacings = Vec::new();
        while coarse >= REFINEMENT && cells > MIN_COARSENED_CELLS {
            spacings.push(coarse * self.resolution);
            coarse = odd(coarse / REFINEMENT);
        }
        spacings.push(self.resolution);
        spacings
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// 4 × 3 m in cells of 0.1 m, with origin (−1, 2) and this share blocked.
    fn scattered(share: f64, seed: u64) -> Grid {
        let mut random = Random::new(seed);
        let blocked = (0..1_200)
            .map(|_| u8::from(random.uniform() < share))
            .collect();
        Grid::new(blocked, 40, 30, 0.1, Point::new(-1.0, 2.0))
    }

    /// Least distance from the segment to any blocked square, all of them looked at.
    fn gap(field: &Grid, a: Point, b: Point) -> f64 {
        (0..field.blocked.len())
            .filter(|&cell| field.blocked[cell] != 0)
            .map(|cell| field.square_distance_squared(cell % 40, cell / 40, a, b))
            .fold(f64::INFINITY, f64::min)
            .sqrt()
    }

    #[test]
    fn every_kind_of_check_agrees_with_a_look_at_all_squares() {
        for (share, radius) in [(0.01, 0.25), (0.05, 0.1), (0.15, 0.03)] {
            let field = scattered(share, 11);
            let mut random = Random::new(5);
            for _ in 0..400 {
                let mut point =
                    || Point::new(4.0 * random.uniform() - 1.0, 2.0 + 3.0 * random.uniform());
                let (a, b) = (point(), point());
                let near = gap(&field, a, b);
                if (near - radius).abs() < 1e-6
                    || !field.inside(a, radius)
                    || !field.inside(b, radius)
                {
                    continue;
                }
                let short = a.towards(b, 0.05);
                assert_eq!(field.segment_clear(a, b, radius), near > radius);
                assert_eq!(field.edge_clear(a, b, radius), near > radius);
                assert_eq!(
                    field.short_clear(a, short, radius),
                    gap(&field, a, short) > radius
                );
            }
        }
    }

    #[test]
    fn an_edge_between_cells_is_clear_exactly_when_the_sweep_is() {
        let field = scattered(0.08, 3);
        for cell in 0..1_100 {
            let (column, row) = (cell % 39, cell / 39);
            for (across, up) in [(1, 0), (0, 1), (1, 1)] {
                let (a, b) = (
                    field.centre(column, row),
                    field.centre(column + across, row + up),
                );
                for radius in [0.0, 0.05, 0.12] {
                    if !(field.point_clear(a, radius) && field.point_clear(b, radius)) {
                        continue;
                    }
                    let swept = field.segment_clear(a, b, radius);
                    assert_eq!(field.hop_clear(a, b, radius), swept, "{a:?} {b:?} {radius}");
                }
            }
        }
    }

    #[test]
    fn nothing_passes_between_two_squares_that_share_a_corner() {
        let mut blocked = vec![0u8; 16];
        (blocked[5], blocked[10]) = (1, 1);
        let field = Grid::new(blocked, 4, 4, 1.0, Point::new(0.0, 0.0));
        assert!(!field.segment_clear(Point::new(1.5, 2.5), Point::new(2.5, 1.5), 0.0));
        assert!(field.segment_clear(Point::new(0.5, 2.5), Point::new(1.5, 3.5), 0.0));
    }

    #[test]
    fn a_large_map_is_searched_coarsely_first_and_a_small_one_as_it_is() {
        let spacings = |side: usize| {
            let field = Grid::new(vec![0; side * side], side, side, 0.1, Point::new(0.0, 0.0));
            field.lattice_spacings(0.35)
        };
        assert_eq!(spacings(100), [0.1]);
        let large = spacings(2_000);
        assert!(large.len() > 1 && large.windows(2).all(|pair| pair[0] > pair[1]));
        assert_eq!(large.last(), Some(&0.1));
    }
}
