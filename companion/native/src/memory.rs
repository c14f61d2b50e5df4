//! What is kept from one plan to the next, so that a changed map, a start that has moved or another goal costs a repair
//! and not a search (section 3.5): the tree, and the legs between stops.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use crate::field::Field;
use crate::geometry::{distance, distance_squared, Point};
use crate::ground;
use crate::mend::Mender;
use crate::random::Random;
use crate::rrt::{Grown, Growth};
use crate::shorten::Shortening;
use crate::tree::{Tree, ROOT};

/// Nodes beyond which looking through the old tree costs more than growing a new one.
const MOST_NODES: usize = 5_000;
/// How many of the nearest nodes a start that has moved tries to join.
const JOINS: usize = 12;

/// A stop's name from plan to plan: a goal's coordinates, or the start wherever it is.
pub type Name = Option<(u64, u64)>;

pub fn name_of(p: Point) -> Name {
    Some((p.x.to_bits(), p.y.to_bits()))
}

/// What became of the tree's nodes or, where mending the legs was enough, of the legs' points.
#[derive(Clone, Copy, Default)]
pub struct Repair {
    pub kept: usize,
    pub pruned: usize,
    /// Nodes, among those kept, that found another parent when their branch was cut; or gaps in legs that were bridged.
    pub rewired: usize,
}

pub struct Memory {
    pub random: Random,
    tree: Option<Tree>,
    goals: Vec<(Point, usize)>,
    pub legs: BTreeMap<(Name, Name), Vec<Point>>,
    /// The goals as they were visited last.
    pub order: Vec<Name>,
    pub repair: Repair,
    pub mender: Mender,
}

impl Memory {
    pub fn new(seed: u64) -> Self {
        Self {
            random: Random::new(seed),
            tree: None,
            goals: Vec::new(),
            legs: BTreeMap::new(),
            order: Vec::new(),
            repair: Repair::default(),
            mender: Mender::default(),
        }
    }

    /// The tree to go on with: the old one, as far as it still holds, or a new one.
    pub fn take_tree<F: Field>(
        &mut self,
        field: &F,
        start: Point,
        goals: &[Point],
        growth: Growth,
        shortening: Shortening,
    ) -> Grown {
        self.repair = Repair::default();
        let old = self
            .tree
            .take()
            .filter(|tree| tree.points.len() <= MOST_NODES);
        let Some(old) = old else {
            return Grown::new(field, start, goals, growth);
        };
        let (tree, places, rewired) = rebuilt(field, &old, start, growth);
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
        let mut grown = Grown::resumed(field, tree, reached, goals, growth);
        self.mend_legs(field, &mut grown, start, goals, shortening);
        grown
    }

    /// Goals that the tree has lost come back to it along their old legs, as far as those can be mended.
    fn mend_legs<F: Field>(
        &mut self,
        field: &F,
        grown: &mut Grown,
        start: Point,
        goals: &[Point],
        shortening: Shortening,
    ) {
        let mut mender = std::mem::take(&mut self.mender);
        let mut names: Vec<Name> = vec![None];
        names.extend(goals.iter().map(|&goal| name_of(goal)));
        let mut tried: BTreeSet<(Name, Name)> = BTreeSet::new();
        loop {
            let node = |grown: &Grown, stop: usize| match stop {
                0 => Some(0),
                stop => grown.reached[stop - 1],
            };
            let lost = |stop: usize| stop > 0 && grown.reached[stop - 1].is_none();
            let next = self.legs.keys().find_map(|&key| {
                let from = names.iter().position(|&name| name == key.0)?;
                let to = names.iter().position(|&name| name == key.1)?;
                (lost(from) != lost(to) && !tried.contains(&key)).then_some((key, from, to))
            });
            let Some((key, from, to)) = next else {
                break;
            };
            tried.insert(key);
            let at = |stop: usize| if stop == 0 { start } else { goals[stop - 1] };
            let ends = (at(from), at(to));
            if !field.point_clear(ends.0, shortening.radius)
                || !field.point_clear(ends.1, shortening.radius)
            {
                continue;
            }
            if let Some(path) = mender.mended(field, &self.legs[&key], ends, shortening) {
                let backwards = lost(from);
                let (root, goal) = if backwards { (to, from) } else { (from, to) };
                let Some(mut at) = node(grown, root) else {
                    continue;
                };
                let count = path.len();
                for step in 1..count {
                    let p = path[if backwards { count - 1 - step } else { step }];
                    at = grown.tree.add(p, at);
                }
                grown.reached[goal - 1] = Some(at);
                self.legs.insert(key, path);
            }
        }
        self.mender = mender;
    }

    /// Makes ready for maps that differ from this one: surveys the ground for ways that legs of the last tour may have
    /// to take then. Nodes and edges of the roadmap.
    pub fn prepare<F: Field>(&mut self, field: &F, settings: Shortening) -> (usize, usize) {
        let mut roadmap = ground::roadmap(field, settings);
        let mut goals = Vec::new();
        let mut from: Name = None;
        for &to in &self.order {
            if let Some(path) = self.legs.get(&(from, to)) {
                roadmap.lay(path);
                goals.extend(path.last());
            }
            from = to;
        }
        roadmap.survey(field, &goals);
        let size = roadmap.size();
        self.mender.roadmap = Some(roadmap);
        self.mender.begin(field, settings.radius);
        size
    }

    /// Drops legs to goals that are no longer asked for.
    pub fn forget_other_goals(&mut self, goals: &[Point]) {
        let asked = |name: &Name| name.is_none() || goals.iter().any(|&p| name_of(p) == *name);
        self.legs.retain(|(from, to), _| asked(from) && asked(to));
    }

    /// Keeps the tree.
    pub fn keep_tree(&mut self, grown: Grown, goals: &[Point]) {
        self.goals = (0..goals.len())
            .filter_map(|goal| grown.reached[goal].map(|node| (goals[goal], node)))
            .collect();
        self.tree = Some(grown.tree);
    }
}

/// The part of `old` that still holds, hung up at `root`: the new tree, each old node's place in it, and how many were
/// rewired. Branches are followed both ways, so that the root may be anywhere.
fn rebuilt<F: Field>(
    field: &F,
    old: &Tree,
    root: Point,
    growth: Growth,
) -> (Tree, Vec<Option<usize>>, usize) {
    let count = old.points.len();
    let mut beside: Vec<Vec<u32>> = vec![Vec::new(); count];
    for (node, &parent) in old.parents.iter().enumerate() {
        if parent != ROOT {
            beside[parent].push(node as u32);
            beside[node].push(parent as u32);
        }
    }
    let mut tree = Tree::new(root, field.bounds(), growth.step);
    let mut places: Vec<Option<usize>> = vec![None; count];
    let mut queue = VecDeque::new();
    if let Some(first) = joint(field, old, root, growth) {
        places[first] = Some(if old.points[first] == root {
            0
        } else {
            tree.add(old.points[first], 0)
        });
        queue.push_back(first);
    }
    let mut rewired = 0;
    let mut orphan = 0;
    loop {
        while let Some(at) = queue.pop_front() {
            let Some(parent) = places[at] else { continue };
            for &next in &beside[at] {
                let next = next as usize;
                if places[next].is_none()
                    && field.segment_clear(old.points[at], old.points[next], growth.radius)
                {
                    places[next] = Some(tree.add(old.points[next], parent));
                    queue.push_back(next);
                }
            }
        }
        // A node that was cut off hangs itself to the nearest that was not, and takes its branch along.
        while orphan < count && queue.is_empty() {
            let p = old.points[orphan];
            if places[orphan].is_none() {
                let nearest = tree.nearest(p);
                let from = tree.points[nearest];
                if distance(from, p) <= 2.0 * growth.step
                    && field.segment_clear(from, p, growth.radius)
                {
                    places[orphan] = Some(tree.add(p, nearest));
                    rewired += 1;
                    queue.push_back(orphan);
                }
            }
            orphan += 1;
        }
        if queue.is_empty() {
            return (tree, places, rewired);
        }
    }
}

/// The nearest node that the root reaches on a straight line.
fn joint<F: Field>(field: &F, old: &Tree, root: Point, growth: Growth) -> Option<usize> {
    if old.points[0] == root {
        return Some(0);
    }
    let mut nodes: Vec<usize> = (0..old.points.len()).collect();
    let by_distance = |&a: &usize, &b: &usize| {
        distance_squared(old.points[a], root)
            .total_cmp(&distance_squared(old.points[b], root))
            .then(a.cmp(&b))
    };
    if nodes.len() > JOINS {
        nodes.select_nth_unstable_by(JOINS - 1, by_distance);
        nodes.truncate(JOINS);
    }
    nodes.sort_unstable_by(by_distance);
    nodes
        .into_iter()
        .find(|&node| field.segment_clear(root, old.points[node], growth.radius))
}
