//! An old leg made valid on a changed map: what stands in obstacles is left out, and gaps are bridged where they are.

use std::cell::Cell;

use crate::field::Field;
use crate::geometry::Point;
use crate::lattice::Lattice;
use crate::search;
use crate::shorten::{self, Shortening};

/// Thousands of cells that one bridge may look at.
const BRIDGE_SEARCH: u32 = 12;

/// `old` from `from` to `to` again, pulled taut; none where a gap has no way around near by.
pub fn mended<F: Field>(
    field: &F,
    lattice: &mut Option<Lattice>,
    old: &[Point],
    (from, to): (Point, Point),
    settings: Shortening,
) -> Option<Vec<Point>> {
    let radius = settings.radius;
    let inner = old.iter().filter(|&&p| p != from && p != to);
    let mut path = vec![from];
    for &next in inner.chain([&to]) {
        let at = path[path.len() - 1];
        if next != to && !field.point_clear(next, radius) {
            continue;
        }
        if field.segment_clear(at, next, radius) {
            path.push(next);
            continue;
        }
        let lattice =
            lattice.get_or_insert_with(|| Lattice::new(field, field.lattice_spacing(), radius));
        let looked = Cell::new(0u32);
        let enough = || {
            looked.set(looked.get() + 1);
            looked.get() > BRIDGE_SEARCH
        };
        let bridge = search::paths(lattice, field, at, &[next], enough)
            .pop()
            .flatten();
        path.extend(bridge?.into_iter().skip(1));
    }
    shorten::settle(field, &mut path, settings, 2);
    Some(path)
}
