//! RRT-Connect: two trees that grow towards each other, for one leg of a tour (Kuffner and LaValle 2000).

use crate::budget::Budget;
use crate::field::Field;
use crate::geometry::{distance_squared, Point};
use crate::random::Random;
use crate::rrt::{steer, uniform_point, Growth};
use crate::tree::Tree;

/// A path from `start` to `goal`, and how many nodes were made.
pub fn plan<F: Field>(
    field: &F,
    start: Point,
    goal: Point,
    growth: Growth,
    random: &mut Random,
    budget: &mut Budget,
) -> (Option<Vec<Point>>, usize) {
    if field.segment_clear(start, goal, growth.radius) {
        return (Some(vec![start, goal]), 2);
    }
    let bounds = field.bounds();
    let mut trees = [
        Tree::new(start, bounds, growth.step),
        Tree::new(goal, bounds, growth.step),
    ];
    let mut active = 0usize;
    while budget.spend() {
        let sample = uniform_point(field, growth.radius, random);
        if let Some(node) = extend(field, &mut trees[active], sample, growth) {
            let reached = trees[active].points[node];
            if let Some(other) = connect(field, &mut trees[1 - active], reached, growth, budget) {
                let mut path = trees[0].path_to(if active == 0 { node } else { other });
                let mut rest = trees[1].path_to(if active == 0 { other } else { node });
                rest.reverse();
                path.extend(rest.into_iter().skip(1));
                return (Some(path), trees[0].points.len() + trees[1].points.len());
            }
        }
        active = 1 - active;
    }
    (None, trees[0].points.len() + trees[1].points.len())
}

/// One step towards `target` (eq. 12–14).
fn extend<F: Field>(field: &F, tree: &mut Tree, target: Point, growth: Growth) -> Option<usize> {
    let nearest = tree.nearest(target); // (eq. 12)
    let from = tree.points[nearest];
    let new = steer(from, target, growth.step)?; // (eq. 13)
    field
        .segment_clear(from, new, growth.radius)
        .then(|| tree.add(new, nearest)) // (eq. 14)
}

/// Steps towards `target` until it is met or something is in the way.
fn connect<F: Field>(
    field: &F,
    tree: &mut Tree,
    target: Point,
    growth: Growth,
    budget: &mut Budget,
) -> Option<usize> {
    let mut at = tree.nearest(target);
    loop {
        if distance_squared(tree.points[at], target) == 0.0 {
            return Some(at);
        }
        if !budget.spend() {
            return None;
        }
        let from = tree.points[at];
        let new = steer(from, target, growth.step)?;
        if !field.segment_clear(from, new, growth.radius) {
            return None;
        }
        at = tree.add(new, at);
    }
}
