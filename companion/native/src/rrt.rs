//! Rapidly-exploring random trees: the paper's section 3.4 (one goal) and figure 3 (one tree, many goals).

use crate::budget::Budget;
use crate::field::Field;
use crate::geometry::{distance, distance_squared, Point};
use crate::random::Random;
use crate::tree::Tree;

/// Settings of a tree's growth.
#[derive(Clone, Copy)]
pub struct Growth {
    pub radius: f64,
    /// Δt of eq. 13 in metres.
    pub step: f64,
    /// Share of the samples that are the nearest unreached goal itself.
    pub bias: f64,
}

/// A tree from the start and, per goal, the node that reached it.
pub struct Grown {
    pub tree: Tree,
    pub reached: Vec<Option<usize>>,
    /// Squared distance from each goal to the nearest node.
    nearest: Vec<f64>,
}

impl Grown {
    pub fn new<F: Field>(field: &F, start: Point, goals: &[Point], growth: Growth) -> Self {
        let mut grown = Self {
            tree: Tree::new(start, field.bounds(), growth.step),
            reached: vec![None; goals.len()],
            nearest: vec![f64::INFINITY; goals.len()],
        };
        grown.meet_goals(field, 0, goals, growth);
        grown
    }

    /// Goes on with a tree that exists already.
    pub fn resumed<F: Field>(
        field: &F,
        tree: Tree,
        reached: Vec<Option<usize>>,
        goals: &[Point],
        growth: Growth,
    ) -> Self {
        let mut grown = Self {
            tree,
            reached,
            nearest: Vec::new(),
        };
        for (index, &goal) in goals.iter().enumerate() {
            let node = grown.tree.nearest(goal);
            let p = grown.tree.points[node];
            grown.nearest.push(distance_squared(p, goal));
            if grown.reached[index].is_none() && field.segment_clear(p, goal, growth.radius) {
                grown.reached[index] = Some(grown.tree.add(goal, node));
            }
        }
        grown
    }

    /// Marks every unreached goal within ε = Δt of `node` that a straight edge reaches.
    fn meet_goals<F: Field>(&mut self, field: &F, node: usize, goals: &[Point], growth: Growth) {
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
        growth: Growth,
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
