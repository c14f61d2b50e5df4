//! What has become of an old leg so far: its points, and which of its stretches are new.

use crate::field::Field;
use crate::geometry::{distance, Point};
use crate::search::Stop;
use crate::shorten::{self, Shortening};

/// Growth of the distance from one point at which a bridge may end to the next.
const FARTHER: f64 = 1.25;
/// Vertices on either side of what is new that are pulled taut with it.
const BESIDE: usize = 2;

/// Share of the way by which a new vertex is moved at least when it is pulled taut.
const LEAST_MOVE: f64 = 1.0 / 8.0;

/// A leg as far as it has been mended, and which of its stretches are new.
pub struct Mended {
    pub path: Vec<Point>,
    pub new: Vec<(usize, usize)>,
}

impl Mended {
    /// Points along the path so far, backwards from `brink`, each with the number of vertices before it.
    pub fn behind(&self, brink: Point, step: f64) -> Vec<Stop> {
        let mut stops = vec![Stop {
            p: brink,
            next: self.path.len(),
        }];
        let back = (0..self.path.len()).rev();
        along(
            brink,
            back.map(|i| (self.path[i], i + 1)),
            step,
            |p, next| {
                stops.push(Stop { p, next });
            },
        );
        stops
    }

    /// Goes on from a sample of the path over `way` to `to`.
    pub fn leave(&mut self, from: &Stop, way: Vec<Point>, to: Point) {
        self.path.truncate(from.next);
        self.new.retain(|&(first, _)| first < from.next);
        let first = from.next.saturating_sub(1);
        self.path
            .extend([from.p].into_iter().chain(way).chain([to]));
        self.new.push((first, self.path.len() - 1));
    }

    /// Settles the stretches that are new.
    pub fn pull_taut<F: Field>(&mut self, field: &F, settings: Shortening) {
        let mut stretches: Vec<(usize, usize)> = Vec::new();
        for &(first, last) in &self.new {
            let first = first.saturating_sub(BESIDE);
            let last = (last + BESIDE).min(self.path.len() - 1);
            match stretches.last_mut() {
                Some(before) if first <= before.1 => before.1 = last.max(before.1),
                _ => stretches.push((first, last)),
            }
        }
        for (first, last) in stretches.into_iter().rev() {
            let mut patch = self.path[first..=last].to_vec();
            let rough = Shortening {
                least_move: LEAST_MOVE,
                ..settings
            };
            shorten::skip_vertices(field, &mut patch, settings.radius);
            shorten::pull_taut(field, &mut patch, rough);
            self.path.splice(first..=last, patch);
        }
    }
}

/// Visits points on a line from `from` over its `vertices`, each `step` after the one before at first and farther and
/// farther on, with the number beside the vertex that comes next; the last vertex is the last.
pub fn along(
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
            step *= FARTHER;
            due += step;
        }
        begun += length;
        if vertex + 1 == count {
            visit(to, number);
        }
        at = to;
    }
}
