//! Makes a valid path shorter and keeps it valid: vertices skipped, random shortcuts, string pulling, corners cut.
//!
//! The cost of a path is its length plus `corner_cost` for every corner, so that a rover that turns on the spot can ask
//! for few corners.

use std::time::Instant;

use crate::budget::Budget;
use crate::geometry::{distance, path_length, Point};
use crate::map::field::Field;
use crate::random::Random;

/// Share of its edges' length that a vertex must be able to save to be looked at.
const MIN_VERTEX_GAIN: f64 = 1e-5;
/// The usual `least_move`.
pub const LEAST_MOVE: f64 = 1.0 / 128.0;
/// Metres that a change must save, against loops of rounding.
const MIN_GAIN_M: f64 = 1e-9;
/// Metres that a cut corner must save beyond what a corner costs; as little from a sweep of string pulling ends it.
const MIN_CUT_GAIN_M: f64 = 1e-4;
/// Share of a path's length that a sweep must save for another one to follow.
const MIN_SWEEP_GAIN: f64 = 1e-4;
/// Shares of a corner's edges at which it is cut, tried in this order.
const CUTS: [f64; 3] = [0.5, 0.25, 0.125];
/// Sweeps of string pulling in `refine` before corners are cut, and after each round of cuts.
const REFINE_SWEEPS: usize = 12;
const SWEEPS_AFTER_CUT: usize = 4;
/// Rounds of cuts in `refine`.
const CUT_ROUNDS: usize = 3;

/// How paths are simplified.
#[derive(Clone, Copy)]
pub struct Simplification {
    /// Radius of the robot in metres.
    pub radius: f64,
    /// Metres that one corner less is worth.
    pub corner_cost: f64,
    /// Share of the way to its target by which string pulling moves a vertex at least.
    pub least_move: f64,
    /// When to leave a path as good as it is by then.
    pub deadline: Option<Instant>,
}

impl Simplification {
    fn late(&self) -> bool {
        self.deadline
            .is_some_and(|deadline| Instant::now() >= deadline)
    }
}

/// Length of a path and what its corners cost, in metres.
pub fn cost(path: &[Point], corner_cost: f64) -> f64 {
    path_length(path) + corner_cost * path.len().saturating_sub(2) as f64
}

/// Drops vertices that a straight edge can skip: from each vertex on to the farthest that it sees.
pub fn skip_vertices<F: Field>(field: &F, path: &mut Vec<Point>, radius: f64) {
    let mut kept = Vec::with_capacity(path.len());
    let mut at = 0usize;
    let last = path.len() - 1;
    kept.push(path[0]);
    while at < last {
        // Galloping keeps long paths off the quadratic number of checks.
        let mut seen = at + 1;
        let mut jump = 2usize;
        while at + jump <= last && field.segment_clear(path[at], path[at + jump], radius) {
            seen = at + jump;
            jump *= 2;
        }
        let most = (at + jump).min(last);
        for candidate in (seen + 1..=most).rev() {
            if field.segment_clear(path[at], path[candidate], radius) {
                seen = candidate;
                break;
            }
        }
        at = seen;
        kept.push(path[at]);
    }
    *path = kept;
}

/// Tries straight lines between random points of the path.
pub fn random_shortcuts<F: Field>(
    field: &F,
    path: &mut Vec<Point>,
    settings: Simplification,
    attempts: usize,
    random: &mut Random,
    budget: &mut Budget,
) {
    for _ in 0..attempts {
        if path.len() < 3 || !budget.spend() {
            return;
        }
        let total = path_length(path);
        let (u, v) = (random.uniform() * total, random.uniform() * total);
        let (first, p) = locate(path, u.min(v));
        let (second, q) = locate(path, u.max(v));
        if first == second {
            continue;
        }
        let mut through = Vec::with_capacity(path.len() + 2);
        through.extend_from_slice(&path[..=first]);
        push_distinct(&mut through, p);
        push_distinct(&mut through, q);
        for &rest in &path[second + 1..] {
            push_distinct(&mut through, rest);
        }
        let gain = cost(path, settings.corner_cost) - cost(&through, settings.corner_cost);
        if gain > MIN_GAIN_M && field.segment_clear(p, q, settings.radius) {
            *path = through;
        }
    }
}

/// Index of the edge at `arc` along the path, and the point there.
fn locate(path: &[Point], arc: f64) -> (usize, Point) {
    let mut left = arc;
    for index in 0..path.len() - 1 {
        let length = distance(path[index], path[index + 1]);
        if left <= length && length > 0.0 {
            return (index, path[index].towards(path[index + 1], left / length));
        }
        left -= length;
    }
    (path.len() - 2, path[path.len() - 1])
}

fn push_distinct(path: &mut Vec<Point>, p: Point) {
    if path
        .last()
        .is_none_or(|&last| distance(last, p) > MIN_GAIN_M)
    {
        path.push(p);
    }
}

/// String pulling: moves every vertex inward as far as both of its edges stay clear. Returns the metres saved.
pub fn pull_string<F: Field>(field: &F, path: &mut [Point], settings: Simplification) -> f64 {
    let (radius, least_move) = (settings.radius, settings.least_move);
    let mut gained = 0.0;
    for index in 1..path.len().saturating_sub(1) {
        if settings.late() {
            break;
        }
        let (before, at, after) = (path[index - 1], path[index], path[index + 1]);
        let (back, ahead) = (distance(before, at), distance(at, after));
        if back + ahead - distance(before, after) <= MIN_VERTEX_GAIN * (back + ahead) {
            continue;
        }
        let chord = before.towards(after, back / (back + ahead));
        for target in [chord, before, after] {
            let old = distance(before, path[index]) + distance(path[index], after);
            let free = |fraction: f64| {
                let moved = path[index].towards(target, fraction);
                field.segment_clear(before, moved, radius)
                    && field.segment_clear(moved, after, radius)
            };
            // Most vertices of a short path cannot move at all: the least move says so.
            if !free(least_move) {
                continue;
            }
            let mut clear = least_move;
            let mut blocked = 1.0;
            while blocked - clear > least_move {
                let middle = 0.5 * (clear + blocked);
                if free(middle) {
                    clear = middle;
                } else {
                    blocked = middle;
                }
            }
            let moved = path[index].towards(target, clear);
            let new = distance(before, moved) + distance(moved, after);
            if new < old - MIN_GAIN_M {
                path[index] = moved;
                gained += old - new;
            }
        }
    }
    gained
}

/// Replaces a corner by two where that saves more than a corner costs.
pub fn cut_corners<F: Field>(field: &F, path: &mut Vec<Point>, settings: Simplification) -> bool {
    let mut changed = false;
    let mut index = 1usize;
    while index + 1 < path.len() {
        let (before, at, after) = (path[index - 1], path[index], path[index + 1]);
        for fraction in CUTS {
            let (p, q) = (at.towards(before, fraction), at.towards(after, fraction));
            let gain = distance(p, at) + distance(at, q) - distance(p, q) - settings.corner_cost;
            if gain > MIN_CUT_GAIN_M && field.segment_clear(p, q, settings.radius) {
                path[index] = p;
                path.insert(index + 1, q);
                changed = true;
                index += 1;
                break;
            }
        }
        index += 1;
    }
    changed
}

/// The cheap descent that every path gets: few checks, most of the gain. At most `sweeps` of string pulling.
pub fn simplify<F: Field>(
    field: &F,
    path: &mut Vec<Point>,
    settings: Simplification,
    sweeps: usize,
) {
    skip_vertices(field, path, settings.radius);
    for _ in 0..sweeps {
        let gained = pull_string(field, path, settings);
        skip_vertices(field, path, settings.radius);
        if gained < MIN_SWEEP_GAIN * path_length(path) {
            break;
        }
    }
}

/// The thorough descent: rounds corners until it no longer pays.
pub fn refine<F: Field>(field: &F, path: &mut Vec<Point>, settings: Simplification) {
    simplify(field, path, settings, REFINE_SWEEPS);
    for _ in 0..CUT_ROUNDS {
        if settings.late() || !cut_corners(field, path, settings) {
            break;
        }
        for _ in 0..SWEEPS_AFTER_CUT {
            if pull_string(field, path, settings) < MIN_CUT_GAIN_M {
                break;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::circles::Circles;

    const SETTINGS: Simplification = Simplification {
        radius: 0.2,
        corner_cost: 0.0,
        least_move: LEAST_MOVE,
        deadline: None,
    };

    /// A disc of 1 m in the middle of 6 × 6 m, and a long way around it along three walls.
    fn around() -> (Circles, Vec<Point>) {
        let field = Circles::new(6.0, 6.0, vec![(Point::new(3.0, 3.0), 1.0)]);
        let corners = [
            (0.5, 3.0),
            (0.5, 1.5),
            (0.5, 0.5),
            (2.0, 0.5),
            (5.5, 0.5),
            (5.5, 3.0),
        ];
        (field, corners.map(|(x, y)| Point::new(x, y)).to_vec())
    }

    fn assert_clear(field: &Circles, path: &[Point]) {
        assert!(path
            .windows(2)
            .all(|edge| field.segment_clear(edge[0], edge[1], SETTINGS.radius)));
    }

    #[test]
    fn skipping_vertices_keeps_the_ends_and_never_touches_anything() {
        let (field, mut path) = around();
        let (ends, before) = ((path[0], path[path.len() - 1]), path.len());
        skip_vertices(&field, &mut path, SETTINGS.radius);
        assert!(path.len() < before);
        assert_eq!((path[0], path[path.len() - 1]), ends);
        assert_clear(&field, &path);
    }

    #[test]
    fn the_refined_path_is_close_to_the_two_tangents_and_the_arc_between() {
        let (field, mut path) = around();
        refine(&field, &mut path, SETTINGS);
        assert_clear(&field, &path);
        // Both ends are 2.5 m from the centre of a disc of 1.2 m with the robot's radius.
        let tangent = (2.5f64 * 2.5 - 1.2 * 1.2).sqrt();
        let arc = 1.2 * (std::f64::consts::PI - 2.0 * (1.2f64 / 2.5).acos());
        let shortest = 2.0 * tangent + arc;
        let length = path_length(&path);
        assert!(
            length >= shortest - 1e-9 && length < 1.03 * shortest,
            "{length} of {shortest}"
        );
    }

    #[test]
    fn random_shortcuts_never_lengthen_a_path_and_count_against_the_budget() {
        let (field, mut path) = around();
        let before = path_length(&path);
        let mut budget = Budget::new(20);
        let mut random = Random::new(1);
        random_shortcuts(&field, &mut path, SETTINGS, 1_000, &mut random, &mut budget);
        assert!(path_length(&path) < before && budget.used == 20);
        assert_clear(&field, &path);
    }

    #[test]
    fn a_corner_that_costs_much_is_not_cut_in_two() {
        let (field, path) = around();
        let dear = Simplification {
            corner_cost: 5.0,
            ..SETTINGS
        };
        assert!(!cut_corners(&field, &mut path.clone(), dear));
        assert!(cut_corners(&field, &mut path.clone(), SETTINGS));
    }
}
