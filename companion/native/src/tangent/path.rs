//! From tangents and arcs to a polyline: every arc becomes a few edges that touch its rim from outside.

use crate::geometry::Point;
use crate::map::field::Field;
use crate::tangent::arcs::Disc;
use crate::tangent::search::{self, Found};

/// Radians that one corner turns at most: such edges are 0.1 % longer than their arc.
const MAX_CORNER_RAD: f64 = 0.1;
/// How often corners are divided when the edges do not fit between discs that nearly touch.
const MAX_DIVISIONS: u32 = 6;

/// A shortest path as a polyline, and what the search took.
pub struct TangentPath {
    /// Both ends included; none when there is no path shorter than the bound.
    pub path: Option<Vec<Point>>,
    /// Tangents that were looked at.
    pub iterations: u64,
}

/// The shortest polyline of tangents and arcs from `start` to `goal` that is shorter than `bound` metres, about. None
/// where more than `most` discs have to be looked at.
pub fn shortest<F: Field>(
    field: &F,
    obstacles: &[(Point, f64)],
    ends: (Point, Point),
    radius: f64,
    (bound, most): (f64, usize),
    late: impl Fn() -> bool,
) -> TangentPath {
    let discs = search::relevant_discs(obstacles, ends, radius, bound);
    if discs.len() > most {
        return TangentPath {
            path: None,
            iterations: 0,
        };
    }
    let found = search::search(field, discs, radius, bound, late);
    let clear = |path: &Vec<Point>| {
        path.windows(2)
            .all(|edge| field.segment_clear(edge[0], edge[1], radius))
    };
    let path = (0..MAX_DIVISIONS)
        .map_while(|division| polyline(&found, ends, MAX_CORNER_RAD / f64::from(1 << division)))
        .find(clear);
    TangentPath {
        path,
        iterations: found.iterations,
    }
}

/// The path with corners of at most `corner` radians.
fn polyline(found: &Found, (start, goal): (Point, Point), corner: f64) -> Option<Vec<Point>> {
    let steps = found.steps.as_ref()?;
    let mut path = vec![start];
    for pair in steps.windows(2) {
        let (disc, turn) = pair[0].to;
        let disc = found.discs[disc];
        let (begin, arc) = (disc.angle(pair[0].end), pair[1].arc);
        let edges = (arc / corner).ceil().max(1.0);
        let half = 0.5 * arc / edges;
        // Corners lie where neighbouring tangents to the rim meet.
        let outside = Disc {
            radius: disc.radius / half.cos(),
            ..disc
        };
        for edge in 0..edges as usize {
            let along = (2 * edge + 1) as f64 * half;
            path.push(outside.at(begin + turn.sign() * along));
        }
    }
    path.push(goal);
    Some(path)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::path_length;
    use crate::map::circles::Circles;
    use std::f64::consts::PI;

    fn planned(circles: &[(f64, f64, f64)], goal: (f64, f64), bound: f64) -> Option<Vec<Point>> {
        let circle = |&(x, y, r): &(f64, f64, f64)| (Point::new(x, y), r);
        let obstacles: Vec<(Point, f64)> = circles.iter().map(circle).collect();
        let field = Circles::new(6.0, 6.0, obstacles.clone());
        let ends = (Point::new(0.5, 3.0), Point::new(goal.0, goal.1));
        let path = shortest(&field, &obstacles, ends, 0.2, (bound, 100), || false).path?;
        assert!(path
            .windows(2)
            .all(|edge| field.segment_clear(edge[0], edge[1], 0.2)));
        Some(path)
    }

    #[test]
    fn around_one_circle_the_path_is_two_tangents_and_an_arc() {
        let path = planned(&[(3.0, 3.0, 1.0)], (5.5, 3.0), f64::INFINITY).unwrap();
        let tangent = (2.5f64 * 2.5 - 1.2 * 1.2).sqrt();
        let optimum = 2.0 * tangent + 1.2 * (PI - 2.0 * (1.2f64 / 2.5).acos());
        assert!(path_length(&path) >= optimum && path_length(&path) < 1.0003 * optimum);
    }

    #[test]
    fn a_passage_a_hair_wider_than_the_robot_is_taken() {
        // A wall of discs with a gap of 0.4026 m for a robot of 0.4 m.
        let circles: Vec<(f64, f64, f64)> = (0..13)
            .map(|n| (3.0, 0.5 * f64::from(n), 0.3))
            .filter(|&(_, y, _)| !(2.6..3.4).contains(&y))
            .map(|(x, y, r)| (x, if y < 3.0 { y - 0.0013 } else { y + 0.0013 }, r))
            .collect();
        let path = planned(&circles, (5.5, 4.0), f64::INFINITY).expect("2.6 mm are enough");
        assert!(path_length(&path) < 5.2);
    }

    #[test]
    fn without_a_passage_or_below_the_bound_there_is_no_path() {
        let wall: Vec<(f64, f64, f64)> = (0..13).map(|n| (3.0, 0.5 * f64::from(n), 0.3)).collect();
        assert_eq!(planned(&wall, (5.5, 3.0), f64::INFINITY), None);
        assert_eq!(planned(&[(3.0, 3.0, 1.0)], (5.5, 3.0), 5.2), None);
    }

    #[test]
    fn overlapping_circles_and_walls_leave_only_the_way_that_is_open() {
        // Two overlapping discs that reach the lower wall: the path leads above both.
        let path = planned(
            &[(2.5, 1.0, 1.0), (3.5, 2.5, 1.2)],
            (5.5, 1.0),
            f64::INFINITY,
        )
        .unwrap();
        assert!(path.iter().any(|p| p.y > 3.5));
    }
}
