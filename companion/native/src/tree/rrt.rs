//! Rapidly-exploring random trees: the paper's section 3.4 (one goal) and figure 3 (one tree, many goals).

use crate::budget::Budget;
use crate::geometry::{distance, distance_squared, Point};
use crate::map::field::Field;
use crate::random::Random;
use crate::tree::search_tree::Tree;

/// How a tree grows.
#[derive(Clone, Copy)]
pub struct GrowthSettings {
    /// Radius of the robot in metres.
    pub radius: f64,
    /// Δt of eq. 13 in metres.
    pub step: f64,
    /// Share of the samples that are the nearest unreached goal itself.
    pub bias: f64,
}

/// A tree from the start and, per goal, the node that reached it.
pub struct GrowingTree {
    /// The tree so far.
    pub tree: Tree,
    /// Per goal the node at it, once there is one.
    pub reached: Vec<Option<usize>>,
    /// Squared distance from each goal to the nearest node.
    nearest: Vec<f64>,
}

impl GrowingTree {
    /// A tree of `start` alone, and of the goals that it sees within a step.
    pub fn new<F: Field>(field: &F, start: Point, goals: &[Point], growth: GrowthSettings) -> Self {
        let mut growing = Self {
            tree: Tree::new(start, field.bounds(), growth.step),
            reached: vec![None; goals.len()],
            nearest: vec![f64::INFINITY; goals.len()],
        };
        growing.meet_goals(field, 0, goals, growth);
        growing
    }

    /// Goes on with a tree that exists already.
    pub fn resumed<F: Field>(
        field: &F,
        tree: Tree,
        reached: Vec<Option<usize>>,
        goals: &[Point],
        growth: GrowthSettings,
    ) -> Self {
        let mut growing = Self {
            tree,
            reached,
            nearest: Vec::new(),
        };
        for (index, &goal) in goals.iter().enumerate() {
            let node = growing.tree.nearest(goal);
            let p = growing.tree.points[node];
            growing.nearest.push(distance_squared(p, goal));
            if growing.reached[index].is_none() && field.segment_clear(p, goal, growth.radius) {
                growing.reached[index] = Some(growing.tree.add(goal, node));
            }
        }
        growing
    }

    /// Labels every unreached goal within ε = Δt of `node` that a straight edge reaches.
    fn meet_goals<F: Field>(
        &mut self,
        field: &F,
        node: usize,
        goals: &[Point],
        growth: GrowthSettings,
    ) {
        let p = self.tree.points[node];
        for (index, &goal) in goals.iter().enumerate() {
            if self.reached[index].is_some() {
                continue;
            }
            let squared = distance_squared(p, goal);
            self.nearest[index] = self.nearest[index].min(squared);
            if squared <= growth.step * growth.step && field.segment_clear(p, goal, growth.radius) {
                self.reached[index] = Some(self.tree.add(goal, node));
            }
        }
    }

    fn nearest_unreached(&self, wanted: &[bool]) -> Option<usize> {
        let mut best: Option<usize> = None;
        for (index, &is_wanted) in wanted.iter().enumerate() {
            if is_wanted
                && self.reached[index].is_none()
                && best.is_none_or(|b| self.nearest[index] < self.nearest[b])
            {
                best = Some(index);
            }
        }
        best
    }

    /// Grows until every wanted goal is reached or the budget is spent (the main loop of figure 3).
    pub fn grow<F: Field>(
        &mut self,
        field: &F,
        goals: &[Point],
        wanted: &[bool],
        growth: GrowthSettings,
        random: &mut Random,
        budget: &mut Budget,
    ) {
        while let Some(target) = self.nearest_unreached(wanted) {
            if !budget.spend() {
                return;
            }
            let sample = if random.uniform() < growth.bias {
                goals[target]
            } else {
                uniform_point(field, growth.radius, random)
            };
            let nearest = self.tree.nearest(sample); // (eq. 12)
            let from = self.tree.points[nearest];
            let Some(new) = steer(from, sample, growth.step) else {
                continue;
            };
            if field.segment_clear(from, new, growth.radius) {
                let node = self.tree.add(new, nearest); // (eq. 14)
                self.meet_goals(field, node, goals, growth);
            }
        }
    }
}

/// A sample anywhere the robot's centre may be, walls considered.
pub fn uniform_point<F: Field>(field: &F, radius: f64, random: &mut Random) -> Point {
    let (low, high) = field.bounds();
    let (u, v) = (random.uniform(), random.uniform());
    Point::new(
        low.x + radius + u * (high.x - low.x - 2.0 * radius),
        low.y + radius + v * (high.y - low.y - 2.0 * radius),
    )
}

/// q_new = q_nearest + Δt (q_rand − q_nearest) / ‖q_rand − q_nearest‖ (eq. 13), or q_rand itself when it is nearer.
pub fn steer(from: Point, sample: Point, step: f64) -> Option<Point> {
    let length = distance(from, sample);
    if length == 0.0 {
        return None;
    }
    if length <= step {
        return Some(sample);
    }
    let fraction = step / length;
    Some(from.towards(sample, fraction))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::circles::Circles;

    const SETTINGS: GrowthSettings = GrowthSettings {
        radius: 0.2,
        step: 0.5,
        bias: 0.2,
    };

    fn grown(goals: &[Point], limit: u64) -> (Circles, GrowingTree, u64) {
        let field = Circles::new(6.0, 6.0, vec![(Point::new(3.0, 3.0), 1.2)]);
        let mut growing = GrowingTree::new(&field, Point::new(0.5, 0.5), goals, SETTINGS);
        let mut budget = Budget::new(limit);
        let wanted = vec![true; goals.len()];
        growing.grow(
            &field,
            goals,
            &wanted,
            SETTINGS,
            &mut Random::new(3),
            &mut budget,
        );
        (field, growing, budget.used)
    }

    #[test]
    fn a_step_is_never_longer_than_its_length_and_ends_at_a_near_sample() {
        let from = Point::new(1.0, 1.0);
        assert_eq!(
            steer(from, Point::new(5.0, 1.0), 0.5),
            Some(Point::new(1.5, 1.0))
        );
        assert_eq!(
            steer(from, Point::new(1.0, 1.3), 0.5),
            Some(Point::new(1.0, 1.3))
        );
        assert_eq!(steer(from, from, 0.5), None);
    }

    #[test]
    fn every_edge_of_the_tree_is_clear_and_no_longer_than_a_step() {
        let (field, growing, _) = grown(&[Point::new(5.5, 5.5), Point::new(5.5, 0.5)], 5_000);
        assert!(growing.reached.iter().all(Option::is_some));
        for (node, &parent) in growing.tree.parents.iter().enumerate().skip(1) {
            let (a, b) = (growing.tree.points[parent], growing.tree.points[node]);
            assert!(field.segment_clear(a, b, SETTINGS.radius));
            assert!(distance(a, b) <= SETTINGS.step + 1e-12);
        }
    }

    #[test]
    fn growth_ends_with_the_budget_when_a_goal_is_out_of_reach() {
        let (_, growing, used) = grown(&[Point::new(3.0, 3.0)], 200);
        assert_eq!(growing.reached, [None]);
        assert_eq!(used, 200);
    }
}
