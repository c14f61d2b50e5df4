//! Makes the tree of the last plan valid on a changed map.

use std::collections::{BTreeSet, VecDeque};

use crate::geometry::{distance, distance_squared, Point};
use crate::map::field::Field;
use crate::path::simplify::Simplification;
use crate::replan::leg_repair::LegRepair;
use crate::replan::stop_name::{name_of, Legs, Name};
use crate::tree::rrt::{GrowingTree, GrowthSettings};
use crate::tree::search_tree::{Tree, ROOT};

/// How many of the nearest nodes a new root tries to connect to.
const MAX_ROOT_NEIGHBOURS: usize = 12;
/// Steps of the tree over which a node that was cut off may be rewired.
const MAX_REWIRED_STEPS: f64 = 2.0;

/// Connects goals that the tree has lost to it along their old legs, as far as those can be repaired.
pub fn restore_goals<F: Field>(
    (legs, leg_repair): (&mut Legs, &mut LegRepair),
    field: &F,
    growing: &mut GrowingTree,
    start: Point,
    goals: &[Point],
    simplification: Simplification,
) {
    let mut names: Vec<Name> = vec![None];
    names.extend(goals.iter().map(|&goal| name_of(goal)));
    let mut tried: BTreeSet<(Name, Name)> = BTreeSet::new();
    loop {
        let node = |growing: &GrowingTree, stop: usize| match stop {
            0 => Some(0),
            stop => growing.reached[stop - 1],
        };
        let lost = |stop: usize| stop > 0 && growing.reached[stop - 1].is_none();
        let next = legs.keys().find_map(|&key| {
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
        if !field.point_clear(ends.0, simplification.radius)
            || !field.point_clear(ends.1, simplification.radius)
        {
            continue;
        }
        if let Some(path) = leg_repair.repair(field, &legs[&key], ends, simplification) {
            let backwards = lost(from);
            let (root, goal) = if backwards { (to, from) } else { (from, to) };
            let Some(mut at) = node(growing, root) else {
                continue;
            };
            let count = path.len();
            for step in 1..count {
                let p = path[if backwards { count - 1 - step } else { step }];
                at = growing.tree.add(p, at);
            }
            growing.reached[goal - 1] = Some(at);
            legs.insert(key, path);
        }
    }
}

/// The part of `old` that is still valid, rooted at `root`: the new tree, each old node's number in it, and how many were
/// rewired. Branches are followed both ways, so that the root may be anywhere.
pub fn rebuild<F: Field>(
    field: &F,
    old: &Tree,
    root: Point,
    growth: GrowthSettings,
) -> (Tree, Vec<Option<usize>>, usize) {
    let count = old.points.len();
    let mut adjacent: Vec<Vec<u32>> = vec![Vec::new(); count];
    for (node, &parent) in old.parents.iter().enumerate() {
        if parent != ROOT {
            adjacent[parent].push(node as u32);
            adjacent[node].push(parent as u32);
        }
    }
    let mut tree = Tree::new(root, field.bounds(), growth.step);
    let mut places: Vec<Option<usize>> = vec![None; count];
    let mut queue = VecDeque::new();
    if let Some(first) = nearest_visible(field, old, root, growth) {
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
            for &next in &adjacent[at] {
                let next = next as usize;
                if places[next].is_none()
                    && field.segment_clear(old.points[at], old.points[next], growth.radius)
                {
                    places[next] = Some(tree.add(old.points[next], parent));
                    queue.push_back(next);
                }
            }
        }
        // A node that was cut off is connected to the nearest one that was not, and takes its branch along.
        while orphan < count && queue.is_empty() {
            let p = old.points[orphan];
            if places[orphan].is_none() {
                let nearest = tree.nearest(p);
                let from = tree.points[nearest];
                if distance(from, p) <= MAX_REWIRED_STEPS * growth.step
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
fn nearest_visible<F: Field>(
    field: &F,
    old: &Tree,
    root: Point,
    growth: GrowthSettings,
) -> Option<usize> {
    if old.points[0] == root {
        return Some(0);
    }
    let mut nodes: Vec<usize> = (0..old.points.len()).collect();
    let by_distance = |&a: &usize, &b: &usize| {
        distance_squared(old.points[a], root)
            .total_cmp(&distance_squared(old.points[b], root))
            .then(a.cmp(&b))
    };
    if nodes.len() > MAX_ROOT_NEIGHBOURS {
        nodes.select_nth_unstable_by(MAX_ROOT_NEIGHBOURS - 1, by_distance);
        nodes.truncate(MAX_ROOT_NEIGHBOURS);
    }
    nodes.sort_unstable_by(by_distance);
    nodes
        .into_iter()
        .find(|&node| field.segment_clear(root, old.points[node], growth.radius))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::circles::Circles;

    const SETTINGS: GrowthSettings = GrowthSettings {
        radius: 0.2,
        step: 0.5,
        bias: 0.0,
    };

    /// Nodes at x = 1 to 9 in a row, rooted on the left.
    fn row() -> Tree {
        let bounds = (Point::new(0.0, 0.0), Point::new(10.0, 2.0));
        let mut tree = Tree::new(Point::new(1.0, 1.0), bounds, SETTINGS.step);
        for x in 2..10 {
            tree.add(Point::new(f64::from(x), 1.0), x as usize - 2);
        }
        tree
    }

    #[test]
    fn a_tree_that_is_still_valid_is_kept_as_a_whole_from_any_root() {
        let field = Circles::new(10.0, 2.0, Vec::new());
        let (tree, places, rewired) = rebuild(&field, &row(), Point::new(5.0, 1.5), SETTINGS);
        assert!(places.iter().all(Option::is_some));
        assert_eq!((tree.points.len(), rewired), (10, 0));
        assert_eq!(tree.points[0], Point::new(5.0, 1.5));
    }

    #[test]
    fn what_lies_behind_an_obstacle_is_cut_off() {
        let field = Circles::new(10.0, 2.0, vec![(Point::new(5.5, 1.0), 1.0)]);
        let (_, places, _) = rebuild(&field, &row(), Point::new(1.0, 1.0), SETTINGS);
        let kept: Vec<bool> = places.iter().map(Option::is_some).collect();
        assert_eq!(
            kept,
            [true, true, true, true, false, false, false, false, false]
        );
    }

    #[test]
    fn a_node_whose_edge_is_cut_is_rewired_to_a_near_one_that_sees_it() {
        let mut old = row();
        // A branch beside the row, and an obstacle on its edge alone.
        let branch = old.add(Point::new(2.0, 1.9), 0);
        let field = Circles::new(10.0, 2.2, vec![(Point::new(1.5, 1.55), 0.1)]);
        let settings = GrowthSettings {
            radius: 0.1,
            ..SETTINGS
        };
        let (tree, places, rewired) = rebuild(&field, &old, Point::new(1.0, 1.0), settings);
        let place = places[branch].expect("the node at (2, 1) sees it");
        assert_eq!(tree.points[tree.parents[place]], Point::new(2.0, 1.0));
        assert_eq!(rewired, 1);
    }
}
