//! Makes an old leg valid on a changed map: a gap is bridged from the last clear point before it to the old line beyond,
//! and only what is new is simplified.

use crate::geometry::{distance, Point};
use crate::lattice::a_star;
use crate::lattice::bidirectional::{self, Terminal};
use crate::lattice::graph::Lattice;
use crate::map::field::Field;
use crate::map::uncached::Uncached;
use crate::path::simplify::{self, Simplification};
use crate::replan::repaired_leg::{sample, RepairedLeg};
use crate::replan::roadmap::Roadmap;
use crate::replan::roadmap_path::roadmap_path;

/// Cells of a lattice above which its memory is not reused for the next map.
const MAX_REUSED_CELLS: usize = 2_000_000;
/// Sweeps of string pulling over a whole leg.
const SWEEPS: usize = 2;
/// Precision of the last clear point before a gap, in spacings of the fine lattice.
const GAP_PRECISION: f64 = 0.5;
/// Spacings of the coarse lattice between the first samples of a leg at which a bridge may begin or end.
const SAMPLE_SPACING: f64 = 2.0;

/// The lattices on which bridges are searched, made when they are needed, and what repairing has done on this map.
#[derive(Default)]
pub struct LegRepair {
    /// Coarse and fine.
    lattices: [Option<Lattice>; 2],
    /// Points of old legs that stay.
    pub kept: usize,
    /// Points of old legs that are left out.
    pub dropped: usize,
    /// Gaps that were bridged.
    pub bridges: usize,
    /// The last leg goes over the roadmap.
    pub by_roadmap: bool,
    /// Paths over the whole map, if they were prepared.
    pub roadmap: Option<Roadmap>,
}

impl LegRepair {
    /// Makes ready for another map: what is known of the last one is dropped, the memory that it took is reused.
    pub fn begin_map<F: Field>(&mut self, field: &F, radius: f64) {
        let lattices = std::mem::take(&mut self.lattices);
        let mut roadmap = self.roadmap.take();
        if let Some(roadmap) = &mut roadmap {
            roadmap.begin_map();
        }
        *self = Self {
            roadmap,
            ..Self::default()
        };
        let spacings = field.lattice_spacings(radius);
        let ends = [spacings[0], spacings[spacings.len() - 1]];
        for (level, (lattice, spacing)) in lattices.into_iter().zip(ends).enumerate() {
            self.lattices[level] = lattice.filter(|lattice| {
                lattice.size() <= MAX_REUSED_CELLS && lattice.matches(field, spacing, radius)
            });
            if let Some(lattice) = &mut self.lattices[level] {
                lattice.reset();
            }
        }
    }

    /// Takes a coarse lattice for bridges to come.
    pub fn keep_lattice<F: Field>(&mut self, field: &F, lattice: Lattice) {
        let level = usize::from(field.lattice_spacings(lattice.radius).len() == 1);
        self.lattices[level].get_or_insert(lattice);
    }

    /// A valid leg from `from` to `to` out of `old`; none where a gap cannot be bridged.
    pub fn repair<F: Field>(
        &mut self,
        field: &F,
        old: &[Point],
        (from, to): (Point, Point),
        settings: Simplification,
    ) -> Option<Vec<Point>> {
        let moved = old.first() != Some(&from) || old.last() != Some(&to);
        let inner = old.iter().filter(|&&p| p != from && p != to);
        let line: Vec<Point> = [&from]
            .into_iter()
            .chain(inner)
            .chain([&to])
            .copied()
            .collect();
        let clear: Vec<bool> = line
            .windows(2)
            .map(|edge| field.edge_clear(edge[0], edge[1], settings.radius))
            .collect();
        let whole = clear.iter().all(|&clear| clear);
        let over_roadmap = (self.roadmap.as_mut().filter(|_| !whole))
            .and_then(|roadmap| roadmap_path(field, roadmap, &line, &clear));
        self.by_roadmap = over_roadmap.is_some();
        let mut leg = match over_roadmap {
            Some(leg) => {
                self.bridges += leg.new.len();
                let stays = |p: &&Point| leg.path.contains(p);
                let kept = line[1..].iter().filter(stays).count();
                self.kept += kept;
                self.dropped += line.len() - 1 - kept;
                leg
            }
            None => self.bridge_gaps(field, &line, &clear, settings.radius)?,
        };
        if moved {
            simplify::simplify(&Uncached(field), &mut leg.path, settings, SWEEPS);
        } else {
            leg.simplify_new(&Uncached(field), settings);
            // Cells that have become free make some points superfluous.
            simplify::skip_vertices(&Uncached(field), &mut leg.path, settings.radius);
        }
        Some(leg.path)
    }

    /// The line with its gaps, where it is not `clear`, bridged by searches over lattices.
    fn bridge_gaps<F: Field>(
        &mut self,
        field: &F,
        line: &[Point],
        clear: &[bool],
        radius: f64,
    ) -> Option<RepairedLeg> {
        let mut leg = RepairedLeg {
            path: vec![line[0]],
            new: Vec::new(),
        };
        let mut next = 1;
        while next < line.len() {
            let at = leg.path[leg.path.len() - 1];
            let known = at == line[next - 1];
            if (known && clear[next - 1]) || (!known && field.segment_clear(at, line[next], radius))
            {
                self.kept += 1;
                leg.path.push(line[next]);
                next += 1;
            } else {
                let after = self.bridge(field, &mut leg, line, next, radius)?;
                self.bridges += 1;
                self.dropped += after - next;
                next = after;
            }
        }
        Some(leg)
    }

    /// Leads `leg` around what blocks the edge to vertex `next` of the old line and back onto that line. Returns the
    /// number of the vertex that comes then.
    fn bridge<F: Field>(
        &mut self,
        field: &F,
        leg: &mut RepairedLeg,
        line: &[Point],
        next: usize,
        radius: f64,
    ) -> Option<usize> {
        let spacings = field.lattice_spacings(radius);
        let (coarse, fine) = (spacings[0], spacings[spacings.len() - 1]);
        let last_clear = last_clear_point(
            field,
            leg.path[leg.path.len() - 1],
            line[next],
            radius,
            GAP_PRECISION * fine,
        );
        let targets = targets(
            field,
            last_clear,
            line,
            next,
            radius,
            SAMPLE_SPACING * coarse,
        );
        let sources = leg.sources(last_clear, SAMPLE_SPACING * coarse);
        let levels = usize::from(spacings.len() == 1)..2;
        let connection = levels.into_iter().find_map(|level| {
            let lattice = self.lattice(field, level, radius);
            bidirectional::search(lattice, field, &sources, &targets)
        });
        let connection = connection?;
        let target = &targets[connection.target];
        leg.splice(&sources[connection.source], connection.inner, target.p);
        Some(target.next)
    }

    /// A leg over the coarse lattice alone, for when a repaired one is long.
    pub fn fresh_leg<F: Field>(
        &mut self,
        field: &F,
        (from, to): (Point, Point),
        settings: Simplification,
    ) -> Option<Vec<Point>> {
        let level = usize::from(field.lattice_spacings(settings.radius).len() == 1);
        let lattice = self.lattice(field, level, settings.radius);
        let found = a_star::search(lattice, field, from, &[to], || false);
        let mut path = found.paths.into_iter().next().flatten()?;
        simplify::simplify(field, &mut path, settings, SWEEPS);
        Some(path)
    }

    fn lattice<F: Field>(&mut self, field: &F, level: usize, radius: f64) -> &mut Lattice {
        let spacings = field.lattice_spacings(radius);
        let spacing = [spacings[0], spacings[spacings.len() - 1]][level];
        self.lattices[level].get_or_insert_with(|| Lattice::new(field, spacing, radius))
    }
}

/// The last point on the edge from `from` to `to` up to which it is clear, within `precision` metres.
fn last_clear_point<F: Field>(
    field: &F,
    from: Point,
    to: Point,
    radius: f64,
    precision: f64,
) -> Point {
    let length = distance(from, to);
    let (mut clear, mut blocked) = (0.0, length);
    while blocked - clear > precision {
        let middle = 0.5 * (clear + blocked);
        if field.segment_clear(from, from.towards(to, middle / length), radius) {
            clear = middle;
        } else {
            blocked = middle;
        }
    }
    from.towards(to, clear / length)
}

/// Samples of the old line from `last_clear` on, beyond the first at which the robot does not fit, each with the number
/// of the vertex that comes next; the line's end is always among them, as the last.
fn targets<F: Field>(
    field: &F,
    last_clear: Point,
    line: &[Point],
    next: usize,
    radius: f64,
    step: f64,
) -> Vec<Terminal> {
    let mut stops = Vec::new();
    let mut blocked = false;
    let last = line.len() - 1;
    sample(
        last_clear,
        (next..last + 1).map(|i| (line[i], i)),
        step,
        |p, next| {
            blocked = blocked || !field.point_clear(p, radius);
            if blocked || p == line[last] {
                stops.push(Terminal { p, next });
            }
        },
    );
    stops
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::path_length;
    use crate::map::grid::Grid;

    const SETTINGS: Simplification = Simplification {
        radius: 0.2,
        corner_cost: 0.0,
        least_move: simplify::LEAST_MOVE,
        deadline: None,
    };

    /// 10 × 10 m in cells of 0.1 m; columns 40 to 45 are blocked in these rows.
    fn map(rows: std::ops::Range<usize>) -> Grid {
        let mut blocked = vec![0u8; 10_000];
        for row in rows {
            blocked[100 * row + 40..100 * row + 46].fill(1);
        }
        Grid::new(blocked, 100, 100, 0.1, Point::new(0.0, 0.0))
    }

    fn line() -> [Point; 3] {
        [(1.0, 5.0), (6.0, 5.0), (9.0, 5.0)].map(|(x, y)| Point::new(x, y))
    }

    #[test]
    fn a_leg_is_led_around_what_has_appeared_and_keeps_the_rest() {
        let field = map(45..55);
        let mut repair = LegRepair::default();
        repair.begin_map(&field, SETTINGS.radius);
        let ends = (line()[0], line()[2]);
        let path = repair
            .repair(&field, &line(), ends, SETTINGS)
            .expect("there is a way around");
        assert!(path
            .windows(2)
            .all(|edge| field.segment_clear(edge[0], edge[1], SETTINGS.radius)));
        assert!(path_length(&path) < 8.4);
        assert_eq!(repair.bridges, 1);
    }

    #[test]
    fn a_leg_that_is_still_clear_stays_as_it_is() {
        let field = map(80..90);
        let mut repair = LegRepair::default();
        repair.begin_map(&field, SETTINGS.radius);
        let path = repair
            .repair(&field, &line(), (line()[0], line()[2]), SETTINGS)
            .unwrap();
        assert_eq!(path_length(&path), 8.0);
        assert_eq!((repair.bridges, repair.dropped), (0, 0));
    }

    #[test]
    fn a_leg_across_a_closed_wall_cannot_be_repaired() {
        let field = map(0..100);
        let mut repair = LegRepair::default();
        repair.begin_map(&field, SETTINGS.radius);
        assert!(repair
            .repair(&field, &line(), (line()[0], line()[2]), SETTINGS)
            .is_none());
    }
}
