//! What stops and the legs between them are called from plan to plan.

use std::collections::BTreeMap;

use crate::geometry::Point;

/// A stop's name from plan to plan: a goal's coordinates, or the start wherever it is.
pub type Name = Option<(u64, u64)>;

/// The name of the goal at `p`.
pub fn name_of(p: Point) -> Name {
    Some((p.x.to_bits(), p.y.to_bits()))
}

/// Paths between stops, by the names of their ends.
pub type Legs = BTreeMap<(Name, Name), Vec<Point>>;
