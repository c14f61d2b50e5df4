//! What is kept from one plan to the next, so that a changed map, a start that has moved or another goal costs a repair
//! and not a search (section 3.5): the tree, and the legs between stops.

use crate::geometry::Point;
use crate::map::field::Field;
use crate::path::simplify::Simplification;
use crate::random::Random;
use crate::replan::leg_repair::LegRepair;
use crate::replan::roadmap_construction;
use crate::replan::stop_name::{name_of, Legs, Name};
use crate::replan::tree_repair;
use crate::tree::rrt::{GrowingTree, GrowthSettings};
use crate::tree::search_tree::Tree;

/// Nodes beyond which repairing the old tree costs more than growing a new one.
const MAX_REPAIRED_NODES: usize = 5_000;

/// What became of the tree's nodes or, where repairing the legs was enough, of the legs' points.
#[derive(Clone, Copy, Default)]
pub struct Repair {
    /// Nodes or points that are still in use.
    pub kept: usize,
    /// Nodes or points that were dropped.
    pub pruned: usize,
    /// Nodes, among those kept, that found another parent when their branch was cut; or gaps in legs that were bridged.
    pub rewired: usize,
}

/// Tree, legs and order of the last plan.
pub struct ReplanState {
    /// Goes on from plan to plan, so that the same calls give the same paths.
    pub random: Random,
    tree: Option<Tree>,
    goals: Vec<(Point, usize)>,
    /// Paths between stops.
    pub legs: Legs,
    /// The goals as they were visited last.
    pub order: Vec<Name>,
    /// What became of the last plan on the map as it is.
    pub repair: Repair,
    /// Makes old legs valid.
    pub leg_repair: LegRepair,
}

impl ReplanState {
    /// Nothing is kept yet.
    pub fn new(seed: u64) -> Self {
        Self {
            random: Random::new(seed),
            tree: None,
            goals: Vec::new(),
            legs: Legs::new(),
            order: Vec::new(),
            repair: Repair::default(),
            leg_repair: LegRepair::default(),
        }
    }

    /// The tree to continue: the old one, as far as it is still valid, or a new one.
    pub fn take_tree<F: Field>(
        &mut self,
        field: &F,
        start: Point,
        goals: &[Point],
        growth: GrowthSettings,
        simplification: Simplification,
    ) -> GrowingTree {
        self.repair = Repair::default();
        let old = self
            .tree
            .take()
            .filter(|tree| tree.points.len() <= MAX_REPAIRED_NODES);
        let Some(old) = old else {
            return GrowingTree::new(field, start, goals, growth);
        };
        let (tree, places, rewired) = tree_repair::rebuild(field, &old, start, growth);
        self.repair = Repair {
            kept: places.iter().flatten().count(),
            pruned: places.iter().filter(|place| place.is_none()).count(),
            rewired,
        };
        let reached = goals
            .iter()
            .map(|goal| {
                let known = self.goals.iter().find(|(p, _)| p == goal);
                known.and_then(|&(_, node)| places[node])
            })
            .collect();
        let mut growing = GrowingTree::resumed(field, tree, reached, goals, growth);
        let legs = (&mut self.legs, &mut self.leg_repair);
        tree_repair::restore_goals(legs, field, &mut growing, start, goals, simplification);
        growing
    }

    /// Makes ready for maps that differ from this one: builds a roadmap of paths that legs of the last tour may have to
    /// take then. Returns its numbers of nodes and edges.
    pub fn prepare<F: Field>(&mut self, field: &F, settings: Simplification) -> (usize, usize) {
        let mut roadmap = roadmap_construction::build(field, settings);
        let mut goals = Vec::new();
        let mut from: Name = None;
        for &to in &self.order {
            if let Some(path) = self.legs.get(&(from, to)) {
                roadmap.insert_path(path);
                goals.extend(path.last());
            }
            from = to;
        }
        roadmap.revalidate(field, &goals);
        let size = roadmap.size();
        self.leg_repair.roadmap = Some(roadmap);
        self.leg_repair.begin_map(field, settings.radius);
        size
    }

    /// Drops legs to goals that are no longer asked for.
    pub fn forget_other_goals(&mut self, goals: &[Point]) {
        let asked = |name: &Name| name.is_none() || goals.iter().any(|&p| name_of(p) == *name);
        self.legs.retain(|(from, to), _| asked(from) && asked(to));
    }

    /// Keeps the tree.
    pub fn keep_tree(&mut self, grown: GrowingTree, goals: &[Point]) {
        self.goals = (0..goals.len())
            .filter_map(|goal| grown.reached[goal].map(|node| (goals[goal], node)))
            .collect();
        self.tree = Some(grown.tree);
    }
}
