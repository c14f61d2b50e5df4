//! The best way over a roadmap: A* that checks an edge when it would settle a node, and no other (in the manner of lazy
//! weighted A*, Cohen, Phillips and Likhachev 2014).

use std::collections::BinaryHeap;

use crate::dijkstra::Entry;
use crate::field::Field;
use crate::roadmap::Roadmap;

/// Metres by which an edge may turn out to be longer without waiting for its turn again.
const LONGER: f64 = 0.02;
/// How much more the way ahead weighs than the way so far: a little length for a good part of the time.
const WEIGHT: f64 = 1.6;
const NONE: u32 = u32::MAX;

/// Nodes from `from` to `to`, each but the first with the edge that leads to it; none when no way holds on this map.
pub fn route<F: Field>(
    roadmap: &mut Roadmap,
    field: &F,
    from: usize,
    to: usize,
) -> Option<Vec<(usize, usize)>> {
    let (nodes, _) = roadmap.size();
    let aim = roadmap.aim(to);
    let mut cost = vec![f64::INFINITY; nodes];
    let mut through = vec![[NONE; 2]; nodes];
    let mut settled = vec![false; nodes];
    // An entry is an edge and from which end it is taken.
    let mut waiting: BinaryHeap<Entry> = BinaryHeap::new();
    let mut at = from;
    cost[from] = 0.0;
    settled[from] = true;
    while at != to {
        for (next, edge, length) in roadmap.around(at) {
            let new = cost[at] + length;
            let ahead = WEIGHT * roadmap.ahead(aim, next, to);
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
            if !settled[next] && roadmap.holds(field, edge) {
                let new =
                    cost[before] + roadmap.length(edge) + WEIGHT * roadmap.ahead(aim, next, to);
                if new > key + LONGER {
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
    let mut way = Vec::new();
    while at != from {
        let [before, edge] = through[at];
        way.push((at, edge as usize));
        at = before as usize;
    }
    way.push((from, NONE as usize));
    way.reverse();
    Some(way)
}
