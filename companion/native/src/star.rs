//! RRT*: RRT that chooses the cheapest parent near by and rewires its neighbours (Karaman and Frazzoli 2011).

use crate::budget::Budget;
use crate::field::Field;
use crate::geometry::{distance, Point};
use crate::random::Random;
use crate::rrt::{steer, uniform_point, Growth};
use crate::tree::Tree;

/// The path found and the number of nodes in the tree. Stops at the first solution, or after `extra`
/// iterations more.
pub fn plan<F: Field>(
    field: &F,
    start: Point,
    goal: Point,
    growth: Growth,
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
                && through < costs[near] - 1e-12
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
