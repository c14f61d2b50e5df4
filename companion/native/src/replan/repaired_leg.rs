//! A leg under repair: its points so far, and which of its stretches are new.

use crate::geometry::{distance, Point};
use crate::lattice::bidirectional::Terminal;
use crate::map::field::Field;
use crate::path::simplify::{self, Simplification};

/// From one sample of a path to the next the distance grows by this factor.
const SPACING_GROWTH: f64 = 1.25;
/// Vertices on either side of a new stretch that are simplified with it.
const OVERLAP: usize = 2;
/// Share of the way by which string pulling moves a new vertex at least: coarse, because a map may soon change again.
const LEAST_MOVE: f64 = 1.0 / 8.0;

/// A leg as far as it has been repaired.
pub struct RepairedLeg {
    /// The points so far, the first one included.
    pub path: Vec<Point>,
    /// First and last vertex of each new stretch, in order.
    pub new: Vec<(usize, usize)>,
}

impl RepairedLeg {
    /// Samples of the path so far, backwards from `last_clear`, each with the number of vertices before it.
    pub fn sources(&self, last_clear: Point, step: f64) -> Vec<Terminal> {
        let mut stops = vec![Terminal {
            p: last_clear,
            next: self.path.len(),
        }];
        let back = (0..self.path.len()).rev();
        sample(
            last_clear,
            back.map(|i| (self.path[i], i + 1)),
            step,
            |p, next| {
                stops.push(Terminal { p, next });
            },
        );
        stops
    }

    /// Continues from a sample of the path over `inner` to `to`.
    pub fn splice(&mut self, from: &Terminal, inner: Vec<Point>, to: Point) {
        self.path.truncate(from.next);
        self.new.retain(|&(first, _)| first < from.next);
        let first = from.next.saturating_sub(1);
        self.path
            .extend([from.p].into_iter().chain(inner).chain([to]));
        self.new.push((first, self.path.len() - 1));
    }

    /// Simplifies the stretches that are new.
    pub fn simplify_new<F: Field>(&mut self, field: &F, settings: Simplification) {
        let mut stretches: Vec<(usize, usize)> = Vec::new();
        for &(first, last) in &self.new {
            let first = first.saturating_sub(OVERLAP);
            let last = (last + OVERLAP).min(self.path.len() - 1);
            match stretches.last_mut() {
                Some(before) if first <= before.1 => before.1 = last.max(before.1),
                _ => stretches.push((first, last)),
            }
        }
        for (first, last) in stretches.into_iter().rev() {
            let mut patch = self.path[first..=last].to_vec();
            let rough = Simplification {
                least_move: LEAST_MOVE,
                ..settings
            };
            simplify::skip_vertices(field, &mut patch, settings.radius);
            simplify::pull_string(field, &mut patch, rough);
            self.path.splice(first..=last, patch);
        }
    }
}

/// Visits samples of a line from `from` over its `vertices`, `step` metres apart at first and farther and farther on,
/// each with the number beside the vertex that comes next; the last vertex is the last sample.
pub fn sample(
    from: Point,
    vertices: impl ExactSizeIterator<Item = (Point, usize)>,
    mut step: f64,
    mut visit: impl FnMut(Point, usize),
) {
    let (mut at, mut begun, mut due) = (from, 0.0, step);
    let count = vertices.len();
    for (vertex, (to, number)) in vertices.enumerate() {
        let length = distance(at, to);
        while due < begun + length {
            visit(at.towards(to, (due - begun) / length), number);
            step *= SPACING_GROWTH;
            due += step;
        }
        begun += length;
        if vertex + 1 == count {
            visit(to, number);
        }
        at = to;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_grow_apart_and_end_with_the_last_vertex() {
        let vertices = [(Point::new(4.0, 0.0), 1), (Point::new(4.0, 6.0), 2)];
        let mut found = Vec::new();
        sample(
            Point::new(0.0, 0.0),
            vertices.into_iter(),
            1.0,
            |p, next| found.push((p, next)),
        );
        assert_eq!(found[0], (Point::new(1.0, 0.0), 1));
        assert_eq!(found.last(), Some(&(Point::new(4.0, 6.0), 2)));
        let arcs: Vec<f64> = found.iter().map(|(p, _)| p.x + p.y).collect();
        let gaps: Vec<f64> = arcs.windows(2).map(|pair| pair[1] - pair[0]).collect();
        assert!(gaps[..gaps.len() - 1]
            .windows(2)
            .all(|pair| pair[1] > 1.2 * pair[0]));
    }

    #[test]
    fn splicing_drops_what_comes_after_the_sample_and_marks_the_rest_as_new() {
        let at = |x: f64| Point::new(x, 0.0);
        let mut leg = RepairedLeg {
            path: vec![at(0.0), at(1.0), at(2.0), at(3.0)],
            new: vec![(2, 3)],
        };
        let sample = Terminal {
            p: at(1.5),
            next: 2,
        };
        leg.splice(&sample, vec![Point::new(2.0, 1.0)], at(4.0));
        assert_eq!(
            leg.path,
            [at(0.0), at(1.0), at(1.5), Point::new(2.0, 1.0), at(4.0)]
        );
        assert_eq!(leg.new, [(1, 4)]);
    }
}
