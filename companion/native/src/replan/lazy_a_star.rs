//! Weighted A* over a roadmap that checks an edge only when it would settle a node (in the manner of lazy weighted A*,
//! Cohen, Phillips and Likhachev 2014).

use std::collections::BinaryHeap;

use crate::lattice::queue::Entry;
use crate::map::field::Field;
use crate::replan::roadmap::Roadmap;

/// Metres by which an edge may turn out to be longer without being queued again.
const MAX_EXCESS_M: f64 = 0.02;
/// Weight of the heuristic: a little length for a good part of the time.
const WEIGHT: f64 = 1.6;
/// No node, no edge.
const NONE: u32 = u32::MAX;

/// Nodes from `from` to `to`, each but the first with the edge that leads to it; none when no path is valid on this map.
pub fn search<F: Field>(
    roadmap: &mut Roadmap,
    field: &F,
    from: usize,
    to: usize,
) -> Option<Vec<(usize, usize)>> {
    let (nodes, _) = roadmap.size();
    let goal = roadmap.known_goal(to);
    let mut cost = vec![f64::INFINITY; nodes];
    let mut through = vec![[NONE; 2]; nodes];
    let mut settled = vec![false; nodes];
    // An entry is an edge and from which end it is taken.
    let mut waiting: BinaryHeap<Entry> = BinaryHeap::new();
    let mut at = from;
    cost[from] = 0.0;
    settled[from] = true;
    while at != to {
        for (next, edge, length) in roadmap.neighbours(at) {
            let new = cost[at] + length;
            let ahead = WEIGHT * roadmap.cost_to_go(goal, next, to);
            if !settled[next] && ahead.is_finite() {
                waiting.push(Entry {
                    key: new + ahead,
                    index: edge * nodes + at,
                });
            }
        }
        loop {
            let Entry { key, index } = waiting.pop()?;
            let (edge, before) = (index / nodes, index % nodes);
            let next = roadmap.far_end(edge, before);
            if !settled[next] && roadmap.check_edge(field, edge) {
                let new = cost[before]
                    + roadmap.length(edge)
                    + WEIGHT * roadmap.cost_to_go(goal, next, to);
                if new > key + MAX_EXCESS_M {
                    waiting.push(Entry { key: new, index });
                    continue;
                }
                settled[next] = true;
                cost[next] = cost[before] + roadmap.length(edge);
                through[next] = [before as u32, edge as u32];
                at = next;
                break;
            }
        }
    }
    let mut path = Vec::new();
    while at != from {
        let [before, edge] = through[at];
        path.push((at, edge as usize));
        at = before as usize;
    }
    path.push((from, NONE as usize));
    path.reverse();
    Some(path)
}
