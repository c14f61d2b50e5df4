//! An index that finds the circles near a point or an edge.

use crate::geometry::Point;

/// Buckets along the longer side at most.
const MAX_BUCKETS: f64 = 512.0;

/// For each square of the map the circles whose bounding box meets it, all in one list.
pub struct CircleBuckets {
    /// Side of a bucket in metres.
    pub size: f64,
    /// Buckets along x.
    pub columns: usize,
    /// Buckets along y.
    pub rows: usize,
    first: Vec<u32>,
    members: Vec<u32>,
}

impl CircleBuckets {
    /// The index of `obstacles` (centre and radius) in the rectangle [0, `width`] × [0, `height`].
    pub fn new(width: f64, height: f64, obstacles: &[(Point, f64)]) -> Self {
        let count = obstacles.len() as f64;
        // As wide as the circles' mean radius: however large they are, each lies in a handful of buckets on average.
        let mean = obstacles.iter().map(|&(_, r)| r).sum::<f64>() / count;
        let size = (width * height / count)
            .sqrt()
            .max(mean)
            .max(width.max(height) / MAX_BUCKETS);
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

    /// Buckets that the bounding box of `a`–`b`, widened by `margin`, meets: left, bottom, right, top, all inclusive.
    pub fn span(&self, a: Point, b: Point, margin: f64) -> (usize, usize, usize, usize) {
        let at = |value: f64, count: usize| ((value / self.size).max(0.0) as usize).min(count - 1);
        (
            at(a.x.min(b.x) - margin, self.columns),
            at(a.y.min(b.y) - margin, self.rows),
            at(a.x.max(b.x) + margin, self.columns),
            at(a.y.max(b.y) + margin, self.rows),
        )
    }

    /// Numbers of the circles in one bucket.
    pub fn at(&self, column: usize, row: usize) -> &[u32] {
        let bucket = row * self.columns + column;
        &self.members[self.first[bucket] as usize..self.first[bucket + 1] as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_circle_is_in_every_bucket_that_its_box_meets_and_in_no_other() {
        let obstacles = [(Point::new(2.5, 2.5), 1.0), (Point::new(7.2, 0.3), 0.1)];
        let buckets = CircleBuckets::new(8.0, 8.0, &obstacles);
        for (circle, &(centre, radius)) in obstacles.iter().enumerate() {
            for row in 0..buckets.rows {
                for column in 0..buckets.columns {
                    let meets = |at: f64, bucket: usize| {
                        let low = bucket as f64 * buckets.size;
                        at + radius >= low && at - radius < low + buckets.size
                    };
                    let expected = meets(centre.x, column) && meets(centre.y, row);
                    assert_eq!(buckets.at(column, row).contains(&(circle as u32)), expected);
                }
            }
        }
    }

    #[test]
    fn circles_outside_the_rectangle_are_kept_in_the_buckets_at_its_edge() {
        let buckets = CircleBuckets::new(4.0, 4.0, &[(Point::new(-3.0, 9.0), 0.5)]);
        assert_eq!(buckets.at(0, buckets.rows - 1), &[0]);
    }
}
