//! RRT*: RRT that chooses the cheapest parent near by and rewires its neighbours (Karaman and Frazzoli 2011).

use crate::budget::Budget;
use crate::geometry::{distance, Point};
use crate::map::field::Field;
use crate::random::Random;
use crate::tree::rrt::{steer, uniform_point, GrowthSettings};
use crate::tree::search_tree::Tree;

/// Metres that rewiring must save, against loops of rounding.
const MIN_GAIN_M: f64 = 1e-12;

/// A tree from a start to one goal that goes on getting better.
pub struct RrtStar {
    tree: Tree,
    costs: Vec<f64>,
    children: Vec<Vec<u32>>,
    goal: Point,
    goal_node: Option<usize>,
    /// Neighbours within gamma · √(ln n / n) are rewired.
    gamma: f64,
}

impl RrtStar {
    /// A tree of `start` alone, and of `goal` if it is in sight.
    pub fn new<F: Field>(field: &F, start: Point, goal: Point, growth: GrowthSettings) -> Self {
        let (low, high) = field.bounds();
        // γ > 2 (1 + 1/d)^(1/d) (area / π)^(1/d) with d = 2: asymptotically optimal whatever the obstacles.
        let area = (high.x - low.x) * (high.y - low.y);
        let mut star = Self {
            tree: Tree::new(start, field.bounds(), growth.step),
            costs: vec![0.0],
            children: vec![Vec::new()],
            goal,
            goal_node: None,
            gamma: 2.0 * 1.5f64.sqrt() * (area / std::f64::consts::PI).sqrt(),
        };
        if field.segment_clear(start, goal, growth.radius) {
            star.goal_node = Some(star.add(goal, 0, distance(start, goal)));
        }
        star
    }

    /// True when the goal is reached.
    pub fn is_solved(&self) -> bool {
        self.goal_node.is_some()
    }

    /// The path to the goal, if it is reached.
    pub fn path(&self) -> Option<Vec<Point>> {
        self.goal_node.map(|node| self.tree.path_to(node))
    }

    /// Length of that path in metres.
    pub fn cost(&self) -> f64 {
        self.goal_node
            .map_or(f64::INFINITY, |node| self.costs[node])
    }

    /// Number of nodes.
    pub fn nodes(&self) -> usize {
        self.tree.points.len()
    }

    /// Grows until the goal is reached or the budget is spent.
    pub fn solve<F: Field>(
        &mut self,
        field: &F,
        growth: GrowthSettings,
        random: &mut Random,
        budget: &mut Budget,
    ) {
        while self.goal_node.is_none() && budget.spend() {
            self.extend(field, growth, random);
        }
    }

    /// One extension, with rewiring.
    pub fn extend<F: Field>(&mut self, field: &F, growth: GrowthSettings, random: &mut Random) {
        let radius = growth.radius;
        let sample = if self.goal_node.is_none() && random.uniform() < growth.bias {
            self.goal
        } else {
            uniform_point(field, radius, random)
        };
        let nearest = self.tree.nearest(sample); // (eq. 12)
        let Some(new) = steer(self.tree.points[nearest], sample, growth.step) else {
            return;
        };
        if !field.segment_clear(self.tree.points[nearest], new, radius) {
            return;
        }
        let count = self.tree.points.len() as f64 + 1.0;
        let reach = (self.gamma * (count.ln() / count).sqrt()).min(growth.step);
        let neighbours = self.tree.near(new, reach);
        let mut parent = nearest;
        let mut cost = self.costs[nearest] + distance(self.tree.points[nearest], new);
        for &near in &neighbours {
            let through = self.costs[near] + distance(self.tree.points[near], new);
            if through < cost && field.segment_clear(self.tree.points[near], new, radius) {
                (parent, cost) = (near, through);
            }
        }
        let node = self.add(new, parent, cost); // (eq. 14)
        for &near in &neighbours {
            let through = cost + distance(new, self.tree.points[near]);
            // The root costs nothing and is never rewired.
            if near != parent
                && through < self.costs[near] - MIN_GAIN_M
                && field.segment_clear(new, self.tree.points[near], radius)
            {
                self.children[self.tree.parents[near]].retain(|&child| child as usize != near);
                self.children[node].push(near as u32);
                self.tree.parents[near] = node;
                self.lower_costs(near, self.costs[near] - through);
            }
        }
        let left = distance(new, self.goal);
        if self.goal_node.is_none()
            && left <= growth.step
            && field.segment_clear(new, self.goal, radius)
        {
            self.goal_node = Some(self.add(self.goal, node, cost + left));
        }
    }

    fn add(&mut self, p: Point, parent: usize, cost: f64) -> usize {
        let node = self.tree.add(p, parent);
        self.costs.push(cost);
        self.children.push(Vec::new());
        self.children[parent].push(node as u32);
        node
    }

    /// Takes `saved` off the cost of `node` and of everything below it.
    fn lower_costs(&mut self, node: usize, saved: f64) {
        let mut pending = vec![node];
        while let Some(at) = pending.pop() {
            self.costs[at] -= saved;
            pending.extend(self.children[at].iter().map(|&child| child as usize));
        }
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

    #[test]
    fn rewiring_shortens_the_path_towards_the_optimum_and_keeps_it_clear() {
        let field = Circles::new(6.0, 6.0, vec![(Point::new(3.0, 3.0), 1.2)]);
        let (start, goal) = (Point::new(0.5, 3.0), Point::new(5.5, 3.0));
        // Two tangents to a circle of 1.4 m and the arc between them.
        let tangent = (2.5f64 * 2.5 - 1.4 * 1.4).sqrt();
        let optimum = 2.0 * tangent + 1.4 * (std::f64::consts::PI - 2.0 * (1.4f64 / 2.5).acos());
        for seed in 0..5 {
            let mut random = Random::new(seed);
            let mut star = RrtStar::new(&field, start, goal, SETTINGS);
            star.solve(&field, SETTINGS, &mut random, &mut Budget::new(100_000));
            let mut before = star.cost();
            for _ in 0..4_000 {
                star.extend(&field, SETTINGS, &mut random);
                assert!(star.cost() <= before);
                before = star.cost();
            }
            let path = star.path().expect("there is a path on either side");
            assert!((path_length(&path) - star.cost()).abs() < 1e-9);
            assert!((path.windows(2)).all(|edge| field.segment_clear(edge[0], edge[1], 0.2)));
            assert!(star.cost() >= optimum && star.cost() < 1.05 * optimum);
        }
    }
}
