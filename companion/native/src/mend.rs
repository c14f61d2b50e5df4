//! An old leg made valid on a changed map: gaps are bridged where they are, from the last point that still holds to the
//! old line beyond, and only what is new is pulled taut.

use crate::closely::Closely;
use crate::detour;
use crate::field::Field;
use crate::geometry::{distance, Point};
use crate::lattice::Lattice;
use crate::mended::{along, Mended};
use crate::roadmap::Roadmap;
use crate::search::{self, Stop};
use crate::shorten::{self, Shortening};

/// Cells of a lattice above which its memory is not kept for the next map.
const KEPT: usize = 2_000_000;

/// The lattices that bridges are searched on, made when they are needed, and what mending did.
#[derive(Default)]
pub struct Mender {
    lattices: [Option<Lattice>; 2],
    /// Points of old legs that stay, and that are left out; gaps that were bridged.
    pub kept: usize,
    pub dropped: usize,
    pub bridges: usize,
    /// The last leg goes over the roadmap.
    pub by_roadmap: bool,
    /// Ways over the ground that somebody has prepared.
    pub roadmap: Option<Roadmap>,
}

impl Mender {
    /// Makes ready for another map: what is known of the last one is forgotten, the memory it took is kept.
    pub fn begin<F: Field>(&mut self, field: &F, radius: f64) {
        let lattices = std::mem::take(&mut self.lattices);
        let mut roadmap = self.roadmap.take();
        if let Some(roadmap) = &mut roadmap {
            roadmap.forget();
        }
        *self = Self {
            roadmap,
            ..Self::default()
        };
        let spacings = field.lattice_spacings(radius);
        let ends = [spacings[0], spacings[spacings.len() - 1]];
        for (level, (lattice, spacing)) in lattices.into_iter().zip(ends).enumerate() {
            self.lattices[level] = lattice
                .filter(|lattice| lattice.size() <= KEPT && lattice.fits(field, spacing, radius));
            if let Some(lattice) = &mut self.lattices[level] {
                lattice.forget();
            }
        }
    }

    /// The coarse lattice, for bridges to come.
    pub fn keep<F: Field>(&mut self, field: &F, lattice: Lattice) {
        let level = usize::from(field.lattice_spacings(lattice.radius).len() == 1);
        self.lattices[level].get_or_insert(lattice);
    }

    /// `old` from `from` to `to` again; none where a gap has no way around.
    pub fn mended<F: Field>(
        &mut self,
        field: &F,
        old: &[Point],
        (from, to): (Point, Point),
        settings: Shortening,
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
        let detour = (self.roadmap.as_mut().filter(|_| !whole))
            .and_then(|roadmap| detour::detour(field, roadmap, &line, &clear));
        self.by_roadmap = detour.is_some();
        let mut leg = match detour {
            Some(leg) => {
                self.bridges += leg.new.len();
                let stays = |p: &&Point| leg.path.contains(p);
                let kept = line[1..].iter().filter(stays).count();
                self.kept += kept;
                self.dropped += line.len() - 1 - kept;
                leg
            }
            None => self.bridged(field, &line, &clear, settings.radius)?,
        };
        if moved {
            shorten::settle(&Closely(field), &mut leg.path, settings, 2);
        } else {
            leg.pull_taut(&Closely(field), settings);
            // Ground that has become free lets some points go.
            shorten::skip_vertices(&Closely(field), &mut leg.path, settings.radius);
        }
        Some(leg.path)
    }

    /// The line with its gaps, where it is not `clear`, bridged by searches over lattices.
    fn bridged<F: Field>(
        &mut self,
        field: &F,
        line: &[Point],
        clear: &[bool],
        radius: f64,
    ) -> Option<Mended> {
        let mut leg = Mended {
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

    /// Leads `leg` around what blocks the way to vertex `next` of the old line, back onto that line; the number of the
    /// vertex that comes then.
    fn bridge<F: Field>(
        &mut self,
        field: &F,
        leg: &mut Mended,
        line: &[Point],
        next: usize,
        radius: f64,
    ) -> Option<usize> {
        let spacings = field.lattice_spacings(radius);
        let (coarse, fine) = (spacings[0], spacings[spacings.len() - 1]);
        let brink = brink(
            field,
            leg.path[leg.path.len() - 1],
            line[next],
            radius,
            0.5 * fine,
        );
        let ahead = ahead(field, brink, line, next, radius, 2.0 * coarse);
        let behind = leg.behind(brink, 2.0 * coarse);
        let levels = usize::from(spacings.len() == 1)..2;
        let joint = levels.into_iter().find_map(|level| {
            let lattice = self.lattice(field, level, radius);
            search::joint(lattice, field, &behind, &ahead)
        });
        let (out, back, way) = joint?;
        leg.leave(&behind[out], way, ahead[back].p);
        Some(ahead[back].next)
    }

    /// A leg on the coarse lattice, for when mending makes it long.
    pub fn other_way<F: Field>(
        &mut self,
        field: &F,
        (from, to): (Point, Point),
        settings: Shortening,
    ) -> Option<Vec<Point>> {
        let level = usize::from(field.lattice_spacings(settings.radius).len() == 1);
        let lattice = self.lattice(field, level, settings.radius);
        let found = search::paths(lattice, field, from, &[to], || false);
        let mut path = found.into_iter().next().flatten()?;
        shorten::settle(field, &mut path, settings, 2);
        Some(path)
    }

    fn lattice<F: Field>(&mut self, field: &F, level: usize, radius: f64) -> &mut Lattice {
        let spacings = field.lattice_spacings(radius);
        let spacing = [spacings[0], spacings[spacings.len() - 1]][level];
        self.lattices[level].get_or_insert_with(|| Lattice::new(field, spacing, radius))
    }
}

/// The last point on the way from `from` to `to` up to which the way is clear, about.
fn brink<F: Field>(field: &F, from: Point, to: Point, radius: f64, precision: f64) -> Point {
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

/// Points of the old line from `brink` on, beyond the first in which the robot does not fit, each with the number of the
/// vertex that comes next; the line's end is always among them, as the last.
fn ahead<F: Field>(
    field: &F,
    brink: Point,
    line: &[Point],
    next: usize,
    radius: f64,
    step: f64,
) -> Vec<Stop> {
    let mut stops = Vec::new();
    let mut blocked = false;
    let last = line.len() - 1;
    along(
        brink,
        (next..last + 1).map(|i| (line[i], i)),
        step,
        |p, next| {
            blocked = blocked || !field.point_clear(p, radius);
            if blocked || p == line[last] {
                stops.push(Stop { p, next });
            }
        },
    );
    stops
}
