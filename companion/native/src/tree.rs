//! A tree of points with a bucket index for nearest neighbours.

use crate::geometry::{distance_squared, Point};

pub const ROOT: usize = usize::MAX;

pub struct Tree {
    pub points: Vec<Point>,
    pub parents: Vec<usize>,
    buckets: Vec<Vec<u32>>,
    low: Point,
    size: f64,
    columns: usize,
    rows: usize,
}

impl Tree {
    /// `bucket`: side of a bucket in metres; widened where the map would need more than 16,384 of them.
    pub fn new(root: Point, bounds: (Point, Point), bucket: f64) -> Self {
        let (low, high) = bounds;
        let widest = (high.x - low.x).max(high.y - low.y);
        let size = bucket.max(widest / 128.0);
        let columns = ((high.x - low.x) / size).floor() as usize + 1;
        let rows = ((high.y - low.y) / size).floor() as usize + 1;
        let mut tree = Self {
            points: Vec::with_capacity(256),
            parents: Vec::with_capacity(256),
            buckets: vec![Vec::new(); columns * rows],
            low,
            size,
            columns,
            rows,
        };
        tree.add(root, ROOT);
        tree
    }

    fn bucket(&self, p: Point) -> (usize, usize) {
        let column = ((p.x - self.low.x) / self.size).max(0.0) as usize;
        let row = ((p.y - self.low.y) / self.size).max(0.0) as usize;
        (column.min(self.columns - 1), row.min(self.rows - 1))
    }

    /// T = T ∪ {q_new} (eq. 14).
    pub fn add(&mut self, p: Point, parent: usize) -> usize {
        let index = self.points.len();
        let (column, row) = self.bucket(p);
        self.points.push(p);
        self.parents.push(parent);
        self.buckets[row * self.columns + column].push(index as u32);
        index
    }

    /// q_nearest = argmin ‖q_i − q_rand‖ (eq. 12); of equals the oldest.
    pub fn nearest(&self, p: Point) -> usize {
        if self.points.len() <= 48 {
            let mut best = (f64::INFINITY, 0usize);
            for (index, &q) in self.points.iter().enumerate() {
                let d = distance_squared(q, p);
                if d < best.0 {
                    best = (d, index);
                }
            }
            return best.1;
        }
        let (column, row) = self.bucket(p);
        let mut best = (f64::INFINITY, usize::MAX);
        for ring in 0..self.columns.max(self.rows) {
            // Every point outside the rings so far is at least (ring - 1) buckets away.
            let reach = (ring as f64 - 1.0).max(0.0) * self.size;
            if best.1 != usize::MAX && best.0 < reach * reach {
                break;
            }
            self.visit_ring(column, row, ring, |index| {
                let d = distance_squared(self.points[index], p);
                if d < best.0 || (d == best.0 && index < best.1) {
                    best = (d, index);
                }
            });
        }
        best.1
    }

    /// Nodes within `radius` of `p`, oldest first.
    pub fn near(&self, p: Point, radius: f64) -> Vec<usize> {
        let (left, bottom) = self.bucket(Point::new(p.x - radius, p.y - radius));
        let (right, top) = self.bucket(Point::new(p.x + radius, p.y + radius));
        let mut found = Vec::new();
        for row in bottom..=top {
            for column in left..=right {
                for &index in &self.buckets[row * self.columns + column] {
                    if distance_squared(self.points[index as usize], p) <= radius * radius {
                        found.push(index as usize);
                    }
                }
            }
        }
        found.sort_unstable();
        found
    }

    fn visit_ring(&self, column: usize, row: usize, ring: usize, mut visit: impl FnMut(usize)) {
        let (c, r, n) = (column as i64, row as i64, ring as i64);
        for y in (r - n).max(0)..=(r + n).min(self.rows as i64 - 1) {
            let on_edge = y == r - n || y == r + n;
            let step = if on_edge || n == 0 { 1 } else { 2 * n };
            let mut x = c - n;
            while x <= c + n {
                if x >= 0 && x < self.columns as i64 {
                    for &index in &self.buckets[y as usize * self.columns + x as usize] {
                        visit(index as usize);
                    }
                }
                x += step;
            }
        }
    }

    /// Path = {q_0, q_1, …, q_goal} (eq. 15), from the root to `node`.
    pub fn path_to(&self, node: usize) -> Vec<Point> {
        let mut path = Vec::new();
        let mut at = node;
        while at != ROOT {
            path.push(self.points[at]);
            at = self.parents[at];
        }
        path.reverse();
        path
    }

    /// Points from node `a` to node `b` through their nearest common ancestor.
    pub fn path_between(&self, a: usize, b: usize) -> Vec<Point> {
        let ancestors = |mut node: usize| {
            let mut line = Vec::new();
            while node != ROOT {
                line.push(node);
                node = self.parents[node];
            }
            line
        };
        let (up, down) = (ancestors(a), ancestors(b));
        let shared = up
            .iter()
            .rev()
            .zip(down.iter().rev())
            .take_while(|(x, y)| x == y)
            .count();
        let mut nodes: Vec<usize> = up[..=up.len() - shared].to_vec();
        nodes.extend(down[..down.len() - shared].iter().rev());
        nodes.iter().map(|&node| self.points[node]).collect()
    }
}
