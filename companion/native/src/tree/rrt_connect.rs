//! RRT-Connect: two trees that grow towards each other, for one leg of a tour (Kuffner and LaValle 2000).

use crate::budget::Budget;
use crate::geometry::{distance_squared, Point};
use crate::map::field::Field;
use crate::random::Random;
use crate::tree::rrt::{steer, uniform_point, GrowthSettings};
use crate::tree::search_tree::Tree;

/// A path from `start` to `goal`, and how many nodes were made.
pub fn plan<F: Field>(
    field: &F,
    start: Point,
    goal: Point,
    growth: GrowthSettings,
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
fn extend<F: Field>(
    field: &F,
    tree: &mut Tree,
    target: Point,
    growth: GrowthSettings,
) -> Option<usize> {
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
    growth: GrowthSettings,
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::circles::Circles;

    #[test]
    fn two_trees_meet_around_an_obstacle_on_a_clear_path() {
        let field = Circles::new(4.0, 4.0, vec![(Point::new(2.0, 2.0), 1.2)]);
        let settings = GrowthSettings {
            radius: 0.2,
            step: 0.4,
            bias: 0.0,
        };
        let (start, goal) = (Point::new(0.5, 0.5), Point::new(3.5, 3.5));
        for seed in 0..20 {
            let mut budget = Budget::new(5_000);
            let mut random = Random::new(seed);
            let (path, nodes) = plan(&field, start, goal, settings, &mut random, &mut budget);
            let path = path.expect("there is a path on either side");
            assert_eq!((path[0], path[path.len() - 1]), (start, goal));
            assert!(path
                .windows(2)
                .all(|edge| field.segment_clear(edge[0], edge[1], 0.2)));
            assert!(nodes >= path.len());
        }
    }
}
