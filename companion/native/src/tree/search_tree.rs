//! A tree of points with a bucket index for nearest neighbours.

use crate::geometry::{distance_squared, Point};

/// Buckets along the longer side of the map, at most.
const MAX_BUCKETS: f64 = 128.0;
/// Up to this many nodes, looking at each costs less than asking the buckets.
const MAX_UNINDEXED: usize = 48;
/// Nodes for which memory is taken at once.
const CAPACITY: usize = 256;

/// The parent of the root.
pub const ROOT: usize = usize::MAX;

/// Nodes, each with its parent.
pub struct Tree {
    /// Where each node is; the root is the first.
    pub points: Vec<Point>,
    /// Number of each node's parent; `ROOT` for the root.
    pub parents: Vec<usize>,
    buckets: Vec<Vec<u32>>,
    low: Point,
    size: f64,
    columns: usize,
    rows: usize,
}

impl Tree {
    /// A tree of a root alone. `bucket`: side of a bucket in metres, widened on maps that would need too many.
    pub fn new(root: Point, bounds: (Point, Point), bucket: f64) -> Self {
        let (low, high) = bounds;
        let widest = (high.x - low.x).max(high.y - low.y);
        let size = bucket.max(widest / MAX_BUCKETS);
        let columns = ((high.x - low.x) / size).floor() as usize + 1;
        let rows = ((high.y - low.y) / size).floor() as usize + 1;
        let mut tree = Self {
            points: Vec::with_capacity(CAPACITY),
            parents: Vec::with_capacity(CAPACITY),
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
        if self.points.len() <= MAX_UNINDEXED {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    const BOUNDS: (Point, Point) = (Point { x: 0.0, y: 0.0 }, Point { x: 10.0, y: 6.0 });

    fn scattered(count: usize) -> Tree {
        let mut random = Random::new(5);
        let mut tree = Tree::new(Point::new(5.0, 3.0), BOUNDS, 0.4);
        for _ in 1..count {
            let p = Point::new(10.0 * random.uniform(), 6.0 * random.uniform());
            let parent = tree.nearest(p);
            tree.add(p, parent);
        }
        tree
    }

    #[test]
    fn the_index_finds_the_node_that_a_look_at_all_of_them_finds() {
        let tree = scattered(500);
        let mut random = Random::new(9);
        for _ in 0..500 {
            let p = Point::new(12.0 * random.uniform() - 1.0, 8.0 * random.uniform() - 1.0);
            let all = 0..tree.points.len();
            let expected = all.min_by(|&a, &b| {
                distance_squared(tree.points[a], p).total_cmp(&distance_squared(tree.points[b], p))
            });
            assert_eq!(Some(tree.nearest(p)), expected);
        }
    }

    #[test]
    fn nodes_near_a_point_are_all_nodes_within_the_radius() {
        let tree = scattered(300);
        let p = Point::new(4.2, 2.7);
        let inside = |&node: &usize| distance_squared(tree.points[node], p) <= 1.0;
        let expected: Vec<usize> = (0..tree.points.len()).filter(inside).collect();
        assert!(!expected.is_empty());
        assert_eq!(tree.near(p, 1.0), expected);
    }

    #[test]
    fn a_path_between_two_branches_turns_at_their_nearest_common_ancestor() {
        let at = |x: f64| Point::new(x, 0.0);
        let mut tree = Tree::new(at(0.0), BOUNDS, 1.0);
        let trunk = tree.add(at(1.0), 0);
        let left = tree.add(at(2.0), trunk);
        let right = tree.add(at(3.0), trunk);
        assert_eq!(tree.path_between(left, right), [at(2.0), at(1.0), at(3.0)]);
        assert_eq!(tree.path_between(trunk, right), [at(1.0), at(3.0)]);
        assert_eq!(tree.path_to(right), [at(0.0), at(1.0), at(3.0)]);
    }
}
