//! A rectangle with circular obstacles: every check is exact. Many circles are found through a grid of buckets.

use crate::field::{wall_distance, Field, TOUCH};
use crate::geometry::{distance, point_segment_squared, Point};

/// Up to this many circles a look at each costs less than finding the near ones.
const FEW: usize = 16;
/// Buckets along the longer side at most.
const MOST_BUCKETS: f64 = 512.0;

pub struct Circles {
    pub width: f64,
    pub height: f64,
    obstacles: Vec<(Point, f64)>,
    index: Option<Buckets>,
}

/// For each square of ground the circles whose bounding box meets it, all in one list.
struct Buckets {
    size: f64,
    columns: usize,
    rows: usize,
    first: Vec<u32>,
    members: Vec<u32>,
}

impl Circles {
    pub fn new(width: f64, height: f64, obstacles: Vec<(Point, f64)>) -> Self {
        let index = (obstacles.len() > FEW).then(|| Buckets::new(width, height, &obstacles));
        Self {
            width,
            height,
            obstacles,
            index,
        }
    }

    fn apart(&self, index: usize, a: Point, b: Point, radius: f64) -> bool {
        let (centre, obstacle) = self.obstacles[index];
        let reach = radius + obstacle - TOUCH;
        point_segment_squared(centre, a, b) >= reach * reach
    }
}

impl Buckets {
    fn new(width: f64, height: f64, obstacles: &[(Point, f64)]) -> Self {
        let count = obstacles.len() as f64;
        // As wide as the circles' mean radius: however large they are, each lies in a handful of buckets on average.
        let mean = obstacles.iter().map(|&(_, r)| r).sum::<f64>() / count;
        let size = (width * height / count)
            .sqrt()
            .max(mean)
            .max(width.max(height) / MOST_BUCKETS);
        let mut buckets = Self {
            size,
            columns: (width / size) as usize + 1,
            rows: (height / size) as usize + 1,
            first: Vec::new(),
            members: Vec::new(),
        };
        let mut counts = vec![0u32; buckets.columns * buckets.rows + 1];
        let boxes: Vec<_> = obstacles
            .iter()
            .map(|&(centre, r)| buckets.span(centre, centre, r))
            .collect();
        for &(left, bottom, right, top) in &boxes {
            for row in bottom..=top {
                for column in left..=right {
                    counts[row * buckets.columns + column + 1] += 1;
                }
            }
        }
        for bucket in 1..counts.len() {
            counts[bucket] += counts[bucket - 1];
        }
        let mut members = vec![0u32; counts[counts.len() - 1] as usize];
        let mut next = counts.clone();
        for (circle, &(left, bottom, right, top)) in boxes.iter().enumerate() {
            for row in bottom..=top {
                for column in left..=right {
                    let slot = &mut next[row * buckets.columns + column];
                    members[*slot as usize] = circle as u32;
                    *slot += 1;
                }
            }
        }
        buckets.first = counts;
        buckets.members = members;
        buckets
    }

    /// Columns and rows of the box around `a`–`b` widened by `margin`: left, bottom, right, top.
    fn span(&self, a: Point, b: Point, margin: f64) -> (usize, usize, usize, usize) {
        let at = |value: f64, count: usize| ((value / self.size).max(0.0) as usize).min(count - 1);
        (
            at(a.x.min(b.x) - margin, self.columns),
            at(a.y.min(b.y) - margin, self.rows),
            at(a.x.max(b.x) + margin, self.columns),
            at(a.y.max(b.y) + margin, self.rows),
        )
    }

    fn at(&self, column: usize, row: usize) -> &[u32] {
        let bucket = row * self.columns + column;
        &self.members[self.first[bucket] as usize..self.first[bucket + 1] as usize]
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
            return (0..self.obstacles.len()).all(|index| self.apart(index, a, b, radius));
        };
        // Buckets are gathered piece by piece, so that a long slanting edge does not look at its whole bounding box;
        // each circle is checked against the whole edge.
        let pieces = (distance(a, b) / (2.0 * buckets.size))
            .ceil()
            .clamp(1.0, 4096.0);
        let mut from = a;
        for piece in 1..=pieces as usize {
            let to = a.towards(b, piece as f64 / pieces);
            let (left, bottom, right, top) = buckets.span(from, to, radius + TOUCH);
            for row in bottom..=top {
                for column in left..=right {
                    for &index in buckets.at(column, row) {
                        if !self.apart(index as usize, a, b, radius) {
                            return false;
                        }
                    }
                }
            }
            from = to;
        }
        true
    }

    fn lattice_spacings(&self, _radius: f64) -> Vec<f64> {
        let coarse = self.width.max(self.height) / 96.0;
        if self.index.is_none() {
            return vec![coarse];
        }
        // Passages are as wide as the circles are apart: finer where there are many.
        vec![coarse, coarse / 4.0]
    }
}
