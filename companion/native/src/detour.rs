//! An old leg led over the roadmap where the map has closed it.

use std::collections::BTreeMap;

use crate::field::Field;
use crate::geometry::Point;
use crate::mended::Mended;
use crate::roadmap::Roadmap;
use crate::route;

/// The best way from end to end of `line` over the roadmap and what is left of the line itself; `clear` tells which of
/// its edges hold. None where the roadmap has no way.
pub fn detour<F: Field>(
    field: &F,
    roadmap: &mut Roadmap,
    line: &[Point],
    clear: &[bool],
) -> Option<Mended> {
    let posts = roadmap.lay(line);
    for post in &posts[1..] {
        if clear[post.next - 1] {
            roadmap.vouch(post.edge);
        }
    }
    let (first, last) = (posts[0].node, posts[posts.len() - 1].node);
    let way = route::route(roadmap, field, first, last)?;
    let by_node: BTreeMap<usize, usize> = posts
        .iter()
        .enumerate()
        .map(|(number, post)| (post.node, number))
        .collect();
    let mut leg = Mended {
        path: vec![line[0]],
        new: Vec::new(),
    };
    let mut before = Some(0usize);
    // The last point is a post between vertices, and the line leads there.
    let mut midway = false;
    for &(node, edge) in &way[1..] {
        let post = by_node.get(&node).copied();
        let on_line = match (before, post) {
            (Some(a), Some(b)) => {
                a.abs_diff(b) == 1 && posts[a.max(b)].edge == edge && roadmap.unchanged(edge)
            }
            _ => false,
        };
        if on_line {
            if midway {
                leg.path.pop();
            }
            leg.path.push(roadmap.at(node));
        } else {
            let begun = leg.path.len() - 1;
            leg.path.extend(roadmap.inner(edge, node));
            leg.path.push(roadmap.at(node));
            match leg.new.last_mut() {
                Some((_, last)) if *last == begun => *last = leg.path.len() - 1,
                _ => leg.new.push((begun, leg.path.len() - 1)),
            }
        }
        // An edge of the line that holds as a whole holds without what lies between.
        midway =
            on_line && post.is_some_and(|post| !posts[post].vertex && clear[posts[post].next - 1]);
        before = post;
    }
    Some(leg)
}
