//! A rectangle with circular obstacles: every check is exact. Many circles are found through a grid of buckets.

use crate::geometry::{distance, point_segment_squared, Point};
use crate::map::circle_buckets::CircleBuckets;
use crate::map::field::{wall_distance, Field, TOUCH_M};

/// Up to this many circles, looking at each costs less than finding the near ones.
const MAX_UNINDEXED: usize = 16;
/// Pieces into which an edge is cut to gather the buckets beside it, at most.
const MAX_PIECES: f64 = 4096.0;
/// Length of such a piece, in buckets.
const PIECE_BUCKETS: f64 = 2.0;
/// Cells of the coarse lattice along the longer side.
const COARSE_CELLS: f64 = 96.0;
/// Spacings of the finest lattice in one radius of the robot, at most.
const MAX_SPACINGS: f64 = 3.0;
/// How much finer the fine lattice is, where there are many circles.
const REFINEMENT: f64 = 4.0;

/// The rectangle [0, width] × [0, height] with circular obstacles.
pub struct Circles {
    width: f64,
    height: f64,
    obstacles: Vec<(Point, f64)>,
    index: Option<CircleBuckets>,
}

impl Circles {
    /// `obstacles`: centre and radius in metres; they may overlap and reach beyond the rectangle.
    pub fn new(width: f64, height: f64, obstacles: Vec<(Point, f64)>) -> Self {
        let index = (obstacles.len() > MAX_UNINDEXED)
            .then(|| CircleBuckets::new(width, height, &obstacles));
        Self {
            width,
            height,
            obstacles,
            index,
        }
    }

    /// True when a disc of `radius` swept from `a` to `b` does not touch this circle.
    fn misses(&self, index: usize, a: Point, b: Point, radius: f64) -> bool {
        let (centre, obstacle) = self.obstacles[index];
        let reach = radius + obstacle - TOUCH_M;
        point_segment_squared(centre, a, b) >= reach * reach
    }
}

impl Field for Circles {
    fn bounds(&self) -> (Point, Point) {
        (Point::new(0.0, 0.0), Point::new(self.width, self.height))
    }

    fn clearance(&self, p: Point) -> f64 {
        let mut nearest = wall_distance(self.bounds(), p);
        let reach = |index: usize| distance(p, self.obstacles[index].0) - self.obstacles[index].1;
        let Some(buckets) = self.index.as_ref().filter(|_| nearest >= 0.0) else {
            return (0..self.obstacles.len()).fold(nearest, |least, index| least.min(reach(index)));
        };
        let (column, row, _, _) = buckets.span(p, p, 0.0);
        // After ring n everything within n buckets' sides has been seen, and nothing outside the walls is nearer
        // than the wall.
        for ring in 0..buckets.columns.max(buckets.rows) {
            let (left, right) = (column.saturating_sub(ring), column + ring);
            for y in row.saturating_sub(ring)..=(row + ring).min(buckets.rows - 1) {
                let whole = y + ring == row || y == row + ring;
                for x in left..=right.min(buckets.columns - 1) {
                    if whole || x + ring == column || x == right {
                        for &index in buckets.at(x, y) {
                            nearest = nearest.min(reach(index as usize));
                        }
                    }
                }
            }
            if nearest <= ring as f64 * buckets.size {
                break;
            }
        }
        nearest
    }

    fn clearance_at_least(&self, p: Point) -> f64 {
        self.clearance(p)
    }

    fn sweep_clear(&self, a: Point, b: Point, radius: f64) -> bool {
        let Some(buckets) = &self.index else {
            return (0..self.obstacles.len()).all(|index| self.misses(index, a, b, radius));
        };
        // Buckets are gathered piece by piece, so that a long slanting edge does not look at its whole bounding box;
        // each circle is checked against the whole edge.
        let pieces = (distance(a, b) / (PIECE_BUCKETS * buckets.size))
            .ceil()
            .clamp(1.0, MAX_PIECES);
        let mut from = a;
        for piece in 1..=pieces as usize {
            let to = a.towards(b, piece as f64 / pieces);
            let (left, bottom, right, top) = buckets.span(from, to, radius + TOUCH_M);
            for row in bottom..=top {
                for column in left..=right {
                    for &index in buckets.at(column, row) {
                        if !self.misses(index as usize, a, b, radius) {
                            return false;
                        }
                    }
                }
            }
            from = to;
        }
        true
    }

    fn circular_obstacles(&self) -> Option<&[(Point, f64)]> {
        Some(&self.obstacles)
    }

    fn lattice_spacings(&self, radius: f64) -> Vec<f64> {
        let coarse = self.width.max(self.height) / COARSE_CELLS;
        // Passages are as wide as the circles are apart: finer where there are many. Passages that are finer still are left
        // to tangents.
        let fine = (coarse / REFINEMENT).max(radius / MAX_SPACINGS);
        if self.index.is_none() || fine >= coarse {
            return vec![coarse];
        }
        vec![coarse, fine]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// 40 circles, far more than are looked at one by one.
    fn many() -> (Circles, Vec<(Point, f64)>) {
        let mut random = Random::new(6);
        let mut circle = || {
            let centre = Point::new(8.0 * random.uniform(), 6.0 * random.uniform());
            (centre, 0.05 + 0.3 * random.uniform())
        };
        let obstacles: Vec<(Point, f64)> = (0..40).map(|_| circle()).collect();
        (Circles::new(8.0, 6.0, obstacles.clone()), obstacles)
    }

    #[test]
    fn the_sweep_is_clear_exactly_when_no_circle_is_nearer_than_the_radius() {
        let (field, obstacles) = many();
        let mut random = Random::new(1);
        let mut clear = 0;
        for _ in 0..2_000 {
            let mut point = || Point::new(8.0 * random.uniform(), 6.0 * random.uniform());
            let (a, b) = (point(), point());
            let near =
                |&(centre, r): &(Point, f64)| point_segment_squared(centre, a, b).sqrt() < r + 0.1;
            let expected = !obstacles.iter().any(near);
            assert_eq!(field.sweep_clear(a, b, 0.1), expected);
            clear += usize::from(expected);
        }
        assert!((20..1_900).contains(&clear));
    }

    #[test]
    fn clearance_is_the_least_distance_to_any_circle_or_wall() {
        let (field, obstacles) = many();
        let mut random = Random::new(3);
        for _ in 0..500 {
            let p = Point::new(8.0 * random.uniform(), 6.0 * random.uniform());
            let circles = obstacles.iter().map(|&(centre, r)| distance(p, centre) - r);
            let expected = circles.fold(wall_distance(field.bounds(), p), f64::min);
            assert!((field.clearance(p) - expected).abs() < 1e-12);
        }
    }

    #[test]
    fn a_disc_may_touch_a_circle_and_a_wall_but_no_more() {
        let field = Circles::new(4.0, 4.0, vec![(Point::new(2.0, 2.0), 0.5)]);
        assert!(field.segment_clear(Point::new(0.2, 2.7), Point::new(3.8, 2.7), 0.2));
        assert!(!field.segment_clear(Point::new(0.2, 2.6999), Point::new(3.8, 2.6999), 0.2));
        assert!(!field.point_clear(Point::new(0.1999, 2.7), 0.2));
    }
}
