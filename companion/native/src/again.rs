//! The last plan's tour made valid on a changed map. Where that works, neither the tree nor a flood is needed.

use std::collections::BTreeSet;

use crate::field::Field;
use crate::geometry::{path_length, Point};
use crate::memory::{name_of, Memory, Name, Repair};
use crate::shorten::Shortening;
use crate::tour::Leg;

/// A mended leg that is longer than it was by more than this is compared with another way.
const LONGER: f64 = 2.0;
/// A mended tour in any order that is longer by more than this gives up the order.
const MUCH_LONGER: f64 = 1.3;

/// Legs in order through all goals; none when one of them can't be mended, is new, or the order should be thought over.
pub fn mended_tour<F: Field>(
    field: &F,
    memory: &mut Memory,
    start: Point,
    goals: &[Point],
    any_order: bool,
    settings: Shortening,
) -> Option<Vec<Leg>> {
    let names: Vec<Name> = goals.iter().map(|&goal| name_of(goal)).collect();
    let sequence: Vec<usize> = if any_order {
        let distinct: BTreeSet<&Name> = names.iter().collect();
        if distinct.len() < names.len() || memory.order.len() != names.len() {
            return None;
        }
        let number = |name| names.iter().position(|other| other == name);
        memory.order.iter().map(number).collect::<Option<_>>()?
    } else {
        (0..goals.len()).collect()
    };
    let known = |from: Name, to: Name| memory.legs.get(&(from, to));
    let mut from: Name = None;
    for &goal in &sequence {
        known(from, names[goal])?;
        from = names[goal];
    }
    if !goals
        .iter()
        .all(|&goal| field.point_clear(goal, settings.radius))
    {
        return None;
    }
    let mender = &mut memory.mender;
    let mut legs = Vec::with_capacity(goals.len());
    let (mut at, mut from) = (start, None);
    let (mut before, mut after) = (0.0, 0.0);
    for goal in sequence {
        let old = memory.legs.get(&(from, names[goal]))?;
        let ends = (at, goals[goal]);
        let mended = mender.mended(field, old, ends, settings);
        let Some(mut path) = mended else {
            // No other search may spend its time on this leg again.
            memory.legs.remove(&(from, names[goal]));
            return None;
        };
        let length = path_length(old);
        if path_length(&path) > LONGER * length && !mender.by_roadmap {
            let other = mender.other_way(field, ends, settings);
            if let Some(other) = other.filter(|other| path_length(other) < path_length(&path)) {
                path = other;
            }
        }
        before += length;
        after += path_length(&path);
        legs.push(Leg { goal, path });
        (at, from) = (goals[goal], names[goal]);
    }
    if any_order && after > MUCH_LONGER * before {
        return None;
    }
    memory.repair = Repair {
        kept: mender.kept,
        pruned: mender.dropped,
        rewired: mender.bridges,
    };
    Some(legs)
}
