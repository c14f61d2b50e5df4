//! Makes a valid path shorter and keeps it valid: skipped vertices, random shortcuts, vertices pulled taut, corners cut.
//!
//! The cost of a path is its length plus `corner_cost` for every corner, so that a rover that turns on the
//! spot can ask for few corners.

use std::time::Instant;

use crate::budget::Budget;
use crate::field::Field;
use crate::geometry::{distance, path_length, Point};
use crate::random::Random;

#[derive(Clone, Copy)]
pub struct Shortening {
    pub radius: f64,
    pub corner_cost: f64,
    /// Share of the way to its target by which a vertex that is pulled taut is moved at least.
    pub least_move: f64,
    /// When to leave a path as good as it is by then.
    pub deadline: Option<Instant>,
}

impl Shortening {
    fn late(&self) -> bool {
        self.deadline
            .is_some_and(|deadline| Instant::now() >= deadline)
    }
}

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
    settings: Shortening,
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
        if gain > 1e-9 && field.segment_clear(p, q, settings.radius) {
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
    if path.last().is_none_or(|&last| distance(last, p) > 1e-9) {
        path.push(p);
    }
}

/// Share of its edges' length that a vertex must be able to save to be looked at.
const LEAST_GAIN: f64 = 1e-5;
/// The usual `least_move`.
pub const LEAST_MOVE: f64 = 1.0 / 128.0;

/// Pulls every vertex inward as far as both of its edges stay clear.
pub fn pull_taut<F: Field>(field: &F, path: &mut [Point], settings: Shortening) -> f64 {
    let (radius, least_move) = (settings.radius, settings.least_move);
    let mut gained = 0.0;
    for index in 1..path.len().saturating_sub(1) {
        if settings.late() {
            break;
        }
        let (before, at, after) = (path[index - 1], path[index], path[index + 1]);
        let (back, ahead) = (distance(before, at), distance(at, after));
        if back + ahead - distance(before, after) <= LEAST_GAIN * (back + ahead) {
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
            // Most vertices of a short path are taut already: the least move says so.
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
            if new < old - 1e-9 {
                path[index] = moved;
                gained += old - new;
            }
        }
    }
    gained
}

/// Replaces a corner by two where that saves more than a corner costs.
pub fn cut_corners<F: Field>(field: &F, path: &mut Vec<Point>, settings: Shortening) -> bool {
    let mut changed = false;
    let mut index = 1usize;
    while index + 1 < path.len() {
        let (before, at, after) = (path[index - 1], path[index], path[index + 1]);
        for fraction in [0.5, 0.25, 0.125] {
            let (p, q) = (at.towards(before, fraction), at.towards(after, fraction));
            let gain = distance(p, at) + distance(at, q) - distance(p, q) - settings.corner_cost;
            if gain > 1e-4 && field.segment_clear(p, q, settings.radius) {
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

/// The cheap descent that every path gets: few checks, most of the gain.
pub fn settle<F: Field>(field: &F, path: &mut Vec<Point>, settings: Shortening, sweeps: usize) {
    skip_vertices(field, path, settings.radius);
    for _ in 0..sweeps {
        let gained = pull_taut(field, path, settings);
        skip_vertices(field, path, settings.radius);
        if gained < 1e-4 * path_length(path) {
            break;
        }
    }
}

/// The thorough descent: rounds corners until it no longer pays.
pub fn polish<F: Field>(field: &F, path: &mut Vec<Point>, settings: Shortening) {
    settle(field, path, settings, 12);
    for _ in 0..3 {
        if settings.late() || !cut_corners(field, path, settings) {
            break;
        }
        for _ in 0..4 {
            if pull_taut(field, path, settings) < 1e-4 {
                break;
            }
        }
    }
}
