//! RRT*: RRT that chooses the cheapest parent near by and rewires its neighbours (Karaman and Frazzoli 2011).

use crate::budget::Budget;
use crate::geometry::{distance, Point};
use crate::map::field::Field;
use crate::random::Random;
use crate::tree::rrt::{steer, uniform_point, GrowthSettings};
use crate::tree::search_tree::Tree;

/// Metres that rewiring must save, against loops of rounding.
const MIN_GAIN_M: f64 = 1e-12;

/// The path found and the number of nodes in the tree. Stops at the first solution, or after `extra`
/// iterations more.
pub fn plan<F: Field>(
    field: &F,
    start: Point,
    goal: Point,
    growth: GrowthSettings,
    extra: u64,
    random: &mut Random,
    budget: &mut Budget,
) -> (Option<Vec<Point>>, usize) {
    let mut tree = Tree::new(start, field.bounds(), growth.step);
    let mut costs = vec![0.0f64];
    let mut children: Vec<Vec<u32>> = vec![Vec::new()];
    let (low, high) = field.bounds();
    // γ > 2 (1 + 1/d)^(1/d) (area / π)^(1/d) with d = 2: asymptotically optimal whatever the obstacles.
    let area = (high.x - low.x) * (high.y - low.y);
    let gamma = 2.0 * 1.5f64.sqrt() * (area / std::f64::consts::PI).sqrt();
    let mut goal_node: Option<usize> = None;
    let mut left = extra;
    if field.segment_clear(start, goal, growth.radius) {
        return (Some(vec![start, goal]), 2);
    }
    while budget.spend() {
        if goal_node.is_some() {
            if left == 0 {
                break;
            }
            left -= 1;
        }
        let sample = if goal_node.is_none() && random.uniform() < growth.bias {
            goal
        } else {
            uniform_point(field, growth.radius, random)
        };
        let nearest = tree.nearest(sample); // (eq. 12)
        let Some(new) = steer(tree.points[nearest], sample, growth.step) else {
            continue;
        };
        if !field.segment_clear(tree.points[nearest], new, growth.radius) {
            continue;
        }
        let count = tree.points.len() as f64;
        let reach = (gamma * ((count + 1.0).ln() / (count + 1.0)).sqrt()).min(growth.step);
        let neighbours = tree.near(new, reach);
        let mut parent = nearest;
        let mut cost = costs[nearest] + distance(tree.points[nearest], new);
        for &near in &neighbours {
            let through = costs[near] + distance(tree.points[near], new);
            if through < cost && field.segment_clear(tree.points[near], new, growth.radius) {
                (parent, cost) = (near, through);
            }
        }
        let node = tree.add(new, parent); // (eq. 14)
        costs.push(cost);
        children.push(Vec::new());
        children[parent].push(node as u32);
        for &near in &neighbours {
            let through = cost + distance(new, tree.points[near]);
            // The root costs nothing and is never rewired.
            if near != parent
                && through < costs[near] - MIN_GAIN_M
                && field.segment_clear(new, tree.points[near], growth.radius)
            {
                children[tree.parents[near]].retain(|&child| child as usize != near);
                children[node].push(near as u32);
                tree.parents[near] = node;
                let saved = costs[near] - through;
                lower_costs(&children, &mut costs, near, saved);
            }
        }
        if goal_node.is_none()
            && distance(new, goal) <= growth.step
            && field.segment_clear(new, goal, growth.radius)
        {
            children[node].push(tree.points.len() as u32);
            children.push(Vec::new());
            goal_node = Some(tree.add(goal, node));
            costs.push(cost + distance(new, goal));
        }
    }
    (goal_node.map(|node| tree.path_to(node)), tree.points.len())
}

/// Takes `saved` off the cost of `node` and of everything below it.
fn lower_costs(children: &[Vec<u32>], costs: &mut [f64], node: usize, saved: f64) {
    let mut pending = vec![node];
    while let Some(at) = pending.pop() {
        costs[at] -= saved;
        pending.extend(children[at].iter().map(|&child| child as usize));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::path_length;
    use crate::map::circles::Circles;

    const SETTINGS: GrowthSettings = GrowthSettings {
        radius: 0.2,
        step: 0.6,
        bias: 0.05,
    };

    fn path(extra: u64, seed: u64) -> Vec<Point> {
        let field = Circles::new(6.0, 6.0, vec![(Point::new(3.0, 3.0), 1.2)]);
        let (start, goal) = (Point::new(0.5, 3.0), Point::new(5.5, 3.0));
        let (mut random, mut budget) = (Random::new(seed), Budget::new(100_000));
        let (path, _) = plan(
            &field,
            start,
            goal,
            SETTINGS,
            extra,
            &mut random,
            &mut budget,
        );
        let path = path.expect("there is a path on either side");
        assert!(path
            .windows(2)
            .all(|edge| field.segment_clear(edge[0], edge[1], SETTINGS.radius)));
        path
    }

    #[test]
    fn rewiring_shortens_the_path_towards_the_optimum() {
        // Two tangents to a circle of 1.4 m and the arc between them.
        let tangent = (2.5f64 * 2.5 - 1.4 * 1.4).sqrt();
        let optimum = 2.0 * tangent + 1.4 * (std::f64::consts::PI - 2.0 * (1.4f64 / 2.5).acos());
        for seed in 0..5 {
            let (first, later) = (path_length(&path(0, seed)), path_length(&path(4_000, seed)));
            assert!(later <= first && later >= optimum);
            assert!(later < 1.05 * optimum, "{later} of {optimum}");
        }
    }
}
