//! An old leg led over the roadmap where the map has closed it.

use std::collections::BTreeMap;

use crate::geometry::Point;
use crate::map::field::Field;
use crate::replan::lazy_a_star;
use crate::replan::repaired_leg::RepairedLeg;
use crate::replan::roadmap::Roadmap;

/// The best path from end to end of `line` over the roadmap and what is left of the line itself; `clear` tells which of
/// its edges are valid. None where the roadmap has no path.
pub fn roadmap_path<F: Field>(
    field: &F,
    roadmap: &mut Roadmap,
    line: &[Point],
    clear: &[bool],
) -> Option<RepairedLeg> {
    let nodes = roadmap.insert_path(line);
    for inserted in &nodes[1..] {
        if clear[inserted.next - 1] {
            roadmap.mark_valid(inserted.edge);
        }
    }
    let (first, last) = (nodes[0].node, nodes[nodes.len() - 1].node);
    let found = lazy_a_star::search(roadmap, field, first, last)?;
    let by_node: BTreeMap<usize, usize> = nodes
        .iter()
        .enumerate()
        .map(|(number, inserted)| (inserted.node, number))
        .collect();
    let mut leg = RepairedLeg {
        path: vec![line[0]],
        new: Vec::new(),
    };
    let mut before = Some(0usize);
    // The last point lies between vertices of the line, which leads there.
    let mut midway = false;
    for &(node, edge) in &found[1..] {
        let number = by_node.get(&node).copied();
        let on_line = match (before, number) {
            (Some(a), Some(b)) => {
                a.abs_diff(b) == 1 && nodes[a.max(b)].edge == edge && roadmap.unchanged(edge)
            }
            _ => false,
        };
        if on_line {
            if midway {
                leg.path.pop();
            }
            leg.path.push(roadmap.point(node));
        } else {
            let first = leg.path.len() - 1;
            leg.path.extend(roadmap.inner(edge, node));
            leg.path.push(roadmap.point(node));
            match leg.new.last_mut() {
                Some((_, last)) if *last == first => *last = leg.path.len() - 1,
                _ => leg.new.push((first, leg.path.len() - 1)),
            }
        }
        // An edge of the line that is valid as a whole needs no point in between.
        midway = on_line && number.is_some_and(|n| !nodes[n].vertex && clear[nodes[n].next - 1]);
        before = number;
    }
    Some(leg)
}
