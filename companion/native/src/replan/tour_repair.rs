//! Makes the last plan's tour valid on a changed map. Where that works, neither the tree nor a flood is needed.

use std::collections::BTreeSet;

use crate::geometry::{path_length, Point};
use crate::map::field::Field;
use crate::path::simplify::Simplification;
use crate::path::tour::Leg;
use crate::replan::state::{Repair, ReplanState};
use crate::replan::stop_name::{name_of, Name};

/// A leg that repair makes longer by more than this factor is compared with a fresh one.
const MAX_LEG_GROWTH: f64 = 2.0;
/// A tour in any order that repair makes longer by more than this factor is ordered anew.
const MAX_TOUR_GROWTH: f64 = 1.3;

/// Legs in order through all goals; none when one of them cannot be repaired, is new, or the goals should be ordered
/// anew.
pub fn repair_tour<F: Field>(
    field: &F,
    state: &mut ReplanState,
    start: Point,
    goals: &[Point],
    any_order: bool,
    settings: Simplification,
) -> Option<Vec<Leg>> {
    let names: Vec<Name> = goals.iter().map(|&goal| name_of(goal)).collect();
    let sequence: Vec<usize> = if any_order {
        let distinct: BTreeSet<&Name> = names.iter().collect();
        if distinct.len() < names.len() || state.order.len() != names.len() {
            return None;
        }
        let number = |name| names.iter().position(|other| other == name);
        state.order.iter().map(number).collect::<Option<_>>()?
    } else {
        (0..goals.len()).collect()
    };
    let known = |from: Name, to: Name| state.legs.get(&(from, to));
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
    let leg_repair = &mut state.leg_repair;
    let mut legs = Vec::with_capacity(goals.len());
    let (mut at, mut from) = (start, None);
    let (mut before, mut after) = (0.0, 0.0);
    for goal in sequence {
        let old = state.legs.get(&(from, names[goal]))?;
        let ends = (at, goals[goal]);
        let repaired = leg_repair.repair(field, old, ends, settings);
        let Some(mut path) = repaired else {
            // No other search shall spend its time on this leg.
            state.legs.remove(&(from, names[goal]));
            return None;
        };
        let length = path_length(old);
        if path_length(&path) > MAX_LEG_GROWTH * length && !leg_repair.by_roadmap {
            let other = leg_repair.fresh_leg(field, ends, settings);
            if let Some(other) = other.filter(|other| path_length(other) < path_length(&path)) {
                path = other;
            }
        }
        before += length;
        after += path_length(&path);
        legs.push(Leg { goal, path });
        (at, from) = (goals[goal], names[goal]);
    }
    if any_order && after > MAX_TOUR_GROWTH * before {
        return None;
    }
    state.repair = Repair {
        kept: leg_repair.kept,
        pruned: leg_repair.dropped,
        rewired: leg_repair.bridges,
    };
    Some(legs)
}
