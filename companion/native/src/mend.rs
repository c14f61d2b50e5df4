//! An old leg made valid on a changed map: what stands in obstacles is left out, gaps are bridged where they are, and
//! only what is new is pulled taut.

use std::cell::Cell;

use crate::field::Field;
use crate::geometry::Point;
use crate::lattice::{Lattice, POCKET};
use crate::search;
use crate::shorten::{self, Shortening};

/// Thousands of cells that one bridge may look at, on the coarse lattice and, only to a leg's end, on the fine one.
const BRIDGE_SEARCH: [u32; 2] = [2, 8];

/// The lattices that bridges are searched on, made when they are needed, and what mending did.
#[derive(Default)]
pub struct Mender {
    lattices: [Option<Lattice>; 2],
    /// Points of old legs that stay, and that are left out; gaps that were bridged.
    pub kept: usize,
    pub dropped: usize,
    pub bridges: usize,
}

impl Mender {
    /// `old` from `from` to `to` again; none where a gap has no way around near by.
    pub fn mended<F: Field>(
        &mut self,
        field: &F,
        old: &[Point],
        (from, to): (Point, Point),
        settings: Shortening,
    ) -> Option<Vec<Point>> {
        let radius = settings.radius;
        let moved = old.first() != Some(&from) || old.last() != Some(&to);
        let mut path = vec![from];
        let inner = old.iter().filter(|&&p| p != from && p != to);
        for &next in inner.chain([&to]) {
            let at = path[path.len() - 1];
            if next != to && !field.point_clear(next, radius) {
                self.dropped += 1;
                continue;
            }
            if field.segment_clear(at, next, radius) {
                self.kept += 1;
                path.push(next);
                continue;
            }
            let Some(bridge) = self.bridge(field, at, next, radius, next == to) else {
                // What lies in a pocket that has closed is left out; the next point may be met again.
                if next == to {
                    return None;
                }
                self.dropped += 1;
                continue;
            };
            self.kept += 1;
            self.bridges += 1;
            let window = path.len().saturating_sub(2);
            let mut patch = path.split_off(window);
            patch.extend(bridge.into_iter().skip(1));
            shorten::settle(field, &mut patch, settings, 2);
            path.extend(patch);
        }
        if moved {
            shorten::settle(field, &mut path, settings, 2);
        } else {
            // Ground that has become free lets some points go.
            shorten::skip_vertices(field, &mut path, radius);
        }
        Some(path)
    }

    fn bridge<F: Field>(
        &mut self,
        field: &F,
        from: Point,
        to: Point,
        radius: f64,
        last: bool,
    ) -> Option<Vec<Point>> {
        let spacings = field.lattice_spacings(radius);
        let ends = [spacings[0], spacings[spacings.len() - 1]];
        let first = usize::from(spacings.len() == 1);
        let count = if last { 2 } else { first + 1 };
        for (level, &spacing) in ends.iter().enumerate().take(count).skip(first) {
            let lattice =
                self.lattices[level].get_or_insert_with(|| Lattice::new(field, spacing, radius));
            let looked = Cell::new(0u32);
            let enough = || {
                looked.set(looked.get() + 1);
                looked.get() > BRIDGE_SEARCH[level]
            };
            let found = search::paths(lattice, field, from, &[to], enough);
            if let Some(path) = found.into_iter().next().flatten() {
                return Some(path);
            }
        }
        None
    }

    /// A leg on the coarse lattice, for when mending does not help; on the fine one when it is the only hope, unless
    /// its end turns out to lie in a small closed pocket.
    pub fn other_way<F: Field>(
        &mut self,
        field: &F,
        (from, to): (Point, Point),
        settings: Shortening,
        only_hope: bool,
    ) -> Option<Vec<Point>> {
        let spacings = field.lattice_spacings(settings.radius);
        let ends = [spacings[0], spacings[spacings.len() - 1]];
        let first = usize::from(spacings.len() == 1);
        let count = if only_hope { 2 } else { first + 1 };
        for (level, &spacing) in ends.iter().enumerate().take(count).skip(first) {
            let lattice = self.lattices[level]
                .get_or_insert_with(|| Lattice::new(field, spacing, settings.radius));
            if level == 1 && !lattice.possible(field, from, to, POCKET) {
                return None;
            }
            let found = search::paths(lattice, field, from, &[to], || false);
            if let Some(mut path) = found.into_iter().next().flatten() {
                shorten::settle(field, &mut path, settings, 2);
                return Some(path);
            }
        }
        None
    }
}
