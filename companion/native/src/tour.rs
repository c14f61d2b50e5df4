//! The legs between the stops of a plan: chosen, ordered, and improved one by one.

use std::collections::BTreeMap;
use std::time::Instant;

use crate::budget::{Budget, Pace};
use crate::connect;
use crate::field::Field;
use crate::geometry::{distance, path_length, Point};
use crate::lattice::Lattice;
use crate::memory::{name_of, Memory};
use crate::order;
use crate::random::Random;
use crate::rrt::{Grown, Growth};
use crate::search;
use crate::shorten::{self, Shortening};

/// What the first search found.
pub struct Stops {
    pub start: Point,
    /// Goals with a way, in the order in which they were asked for or, staged, visited.
    pub visits: Vec<usize>,
    /// Staged: per visit the way from the visit before.
    pub ways: Vec<Vec<Point>>,
    /// The one tree; none when the search was staged.
    pub grown: Option<Grown>,
    /// A coarse lattice, if one was searched: the ground is such that trees have a hard time.
    pub lattice: Option<Lattice>,
    pub nodes: usize,
}

pub struct Leg {
    pub goal: usize,
    pub path: Vec<Point>,
}

pub struct Tour {
    /// The start and the goals with a way, and those goals' numbers.
    pub stops: Vec<Point>,
    pub visits: Vec<usize>,
    pub legs: Vec<Leg>,
    pub nodes: usize,
    /// When the first valid tour was known.
    pub first: Instant,
}

impl Stops {
    /// All goals, with nothing searched: the old tour leads to them.
    pub fn mended(start: Point, goals: usize) -> Self {
        Self {
            start,
            visits: (0..goals).collect(),
            ways: Vec::new(),
            grown: None,
            lattice: None,
            nodes: 0,
        }
    }
}

impl Tour {
    /// A tour that is known already.
    pub fn mended(start: Point, goals: &[Point], legs: Vec<Leg>) -> Self {
        Self {
            stops: [&[start], goals].concat(),
            visits: (0..goals.len()).collect(),
            nodes: legs.iter().map(|leg| leg.path.len()).sum(),
            legs,
            first: Instant::now(),
        }
    }
}

/// Tree extensions that a leg of its own may take.
const LEG_TRIES: u64 = 400;

/// Everything that the search for shorter legs needs.
pub struct Search<'a, F: Field> {
    pub field: &'a F,
    pub growth: Growth,
    pub shortening: Shortening,
    pub random: &'a mut Random,
    pub budget: &'a mut Budget,
}

impl<F: Field> Search<'_, F> {
    /// A fresh path for one leg, pulled taut.
    fn restart(&mut self, from: Point, to: Point) -> (Option<Vec<Point>>, usize) {
        let whole = self.budget.capped(LEG_TRIES);
        let (path, nodes) =
            connect::plan(self.field, from, to, self.growth, self.random, self.budget);
        self.budget.restore(whole);
        let taut = path.map(|mut path| {
            shorten::settle(self.field, &mut path, self.shortening, 3);
            path
        });
        (taut, nodes)
    }

    fn cost(&self, path: &[Point]) -> f64 {
        shorten::cost(path, self.shortening.corner_cost)
    }

    /// A leg from scratch: the lattice's way, or the shorter of `raw` and a fresh one; and how many nodes were made.
    fn fresh_leg(
        &mut self,
        lattice: &mut Option<Lattice>,
        raw: impl FnOnce() -> Vec<Point>,
        (from, to): (Point, Point),
    ) -> (Vec<Point>, usize) {
        let budget = &*self.budget;
        let found = lattice.as_mut().and_then(|lattice| {
            if budget.late() {
                return None;
            }
            let mut found = search::paths(lattice, self.field, from, &[to], || budget.late());
            found.pop().flatten()
        });
        if let Some(mut path) = found {
            shorten::settle(self.field, &mut path, self.shortening, 3);
            return (path, 0);
        }
        self.better_of(raw())
    }

    /// The shorter of `path`, made taut, and a fresh one.
    fn better_of(&mut self, mut path: Vec<Point>) -> (Vec<Point>, usize) {
        shorten::settle(self.field, &mut path, self.shortening, 3);
        if path.len() <= 2 {
            return (path, 0);
        }
        let (fresh, nodes) = self.restart(path[0], path[path.len() - 1]);
        match fresh {
            Some(fresh) if self.cost(&fresh) < self.cost(&path) => (fresh, nodes),
            _ => (path, nodes),
        }
    }

    /// From stops to a tour: legs in order, each already short.
    ///
    /// The legs that `memory` holds are mended where the map has changed, and take up what is found.
    pub fn tour(
        &mut self,
        stops: &mut Stops,
        goals: &[Point],
        any_order: bool,
        memory: &mut Memory,
    ) -> Tour {
        let first = Instant::now();
        let mut tour = Tour {
            stops: vec![stops.start],
            visits: stops.visits.clone(),
            legs: Vec::new(),
            nodes: 0,
            first,
        };
        tour.stops.extend(stops.visits.iter().map(|&v| goals[v]));
        let mut lattice = stops.lattice.take();
        let stops = &*stops;
        let Some(grown) = &stops.grown else {
            for (&goal, way) in stops.visits.iter().zip(&stops.ways) {
                let mut path = way.clone();
                shorten::settle(self.field, &mut path, self.shortening, 3);
                tour.legs.push(Leg { goal, path });
            }
            return tour;
        };
        let points = tour.stops.clone();
        let Memory {
            mender, legs: kept, ..
        } = memory;
        let name = |stop: usize| (stop > 0).then(|| name_of(points[stop])).flatten();
        let mut paths: BTreeMap<(usize, usize), Vec<Point>> = BTreeMap::new();
        let sequence = if any_order {
            order::lazily(straight(&points), |from, to| {
                let old = kept.remove(&(name(from), name(to)));
                let old = old.or_else(|| kept.remove(&(name(to), name(from))).map(reversed));
                let ends = (points[from], points[to]);
                let mended =
                    old.and_then(|old| mender.mended(self.field, &old, ends, self.shortening));
                let path = if let Some(path) = mended {
                    path
                } else {
                    let raw = || raw_leg(stops, grown, from, to);
                    let (path, nodes) = self.fresh_leg(&mut lattice, raw, ends);
                    tour.nodes += nodes;
                    path
                };
                let length = path_length(&path);
                paths.insert((from, to), path);
                length
            })
        } else {
            (1..points.len()).collect()
        };
        let mut from = 0usize;
        for to in sequence {
            let path = paths
                .remove(&(from, to))
                .or_else(|| paths.remove(&(to, from)).map(reversed))
                .or_else(|| {
                    let old = kept.remove(&(name(from), name(to)))?;
                    let ends = (points[from], points[to]);
                    mender.mended(self.field, &old, ends, self.shortening)
                })
                .unwrap_or_else(|| {
                    let raw = || raw_leg(stops, grown, from, to);
                    let ends = (points[from], points[to]);
                    let (path, nodes) = self.fresh_leg(&mut lattice, raw, ends);
                    tour.nodes += nodes;
                    path
                });
            tour.legs.push(Leg {
                goal: stops.visits[to - 1],
                path,
            });
            from = to;
        }
        for ((from, to), path) in paths {
            kept.insert((name(from), name(to)), path);
        }
        if let Some(lattice) = lattice {
            mender.keep(self.field, lattice);
        }
        tour
    }

    /// Ways over finer and finer lattices, then restarts and shortcuts, leg by leg, until the budget is spent or every
    /// leg is a straight line.
    pub fn improve(&mut self, tour: &mut Tour, any_order: bool) {
        let winding = |tour: &Tour| tour.legs.iter().any(|leg| leg.path.len() > 2);
        let radius = self.shortening.radius;
        let mut pace = Pace::default();
        for spacing in self.field.lattice_spacings(radius) {
            let (low, high) = self.field.bounds();
            let cells = (high.x - low.x) * (high.y - low.y) / (spacing * spacing);
            if !winding(tour) || !self.budget.affords(pace.expected(cells), cells) {
                break;
            }
            let began = Instant::now();
            let mut lattice = Lattice::new(self.field, spacing, radius);
            if any_order && tour.legs.len() > 1 {
                self.reorder(tour, &mut lattice);
            } else {
                self.retrace(tour, &mut lattice);
            }
            pace.saw(cells, began.elapsed().as_secs_f64());
        }
        let mut round = 0usize;
        let mut best: Vec<f64> = tour.legs.iter().map(|leg| self.cost(&leg.path)).collect();
        while !self.budget.exhausted() && !self.budget.late() && winding(tour) {
            for (leg, best) in tour.legs.iter_mut().zip(&mut best) {
                if leg.path.len() <= 2 || !self.budget.spend() {
                    continue;
                }
                let (candidate, nodes) = self.candidate(leg, *best, round);
                tour.nodes += nodes;
                if let Some(mut path) = candidate {
                    shorten::polish(self.field, &mut path, self.shortening);
                    let cost = self.cost(&path);
                    if cost < *best {
                        *best = cost;
                        leg.path = path;
                    }
                }
            }
            round += 1;
        }
    }

    /// Something that may become a better leg: the leg itself, shortcuts, or a fresh search.
    fn candidate(&mut self, leg: &Leg, best: f64, round: usize) -> (Option<Vec<Point>>, usize) {
        let (from, to) = (leg.path[0], leg.path[leg.path.len() - 1]);
        if round == 0 {
            return (Some(leg.path.clone()), 0);
        }
        if round % 4 == 3 {
            let mut path = leg.path.clone();
            let (field, settings) = (self.field, self.shortening);
            shorten::random_shortcuts(field, &mut path, settings, 16, self.random, self.budget);
            return (Some(path), 0);
        }
        let (path, nodes) = self.restart(from, to);
        (path.filter(|path| self.cost(path) < 1.1 * best), nodes)
    }

    /// The lattice's way, pulled taut; none when there is none or time is up.
    fn lattice_way(&self, lattice: &mut Lattice, from: Point, to: Point) -> Option<Vec<Point>> {
        let budget = &*self.budget;
        let found = search::paths(lattice, self.field, from, &[to], || budget.late());
        let mut path = found.into_iter().next().flatten()?;
        shorten::settle(self.field, &mut path, self.shortening, 3);
        Some(path)
    }

    /// Each leg by the lattice's way where that is shorter.
    fn retrace(&mut self, tour: &mut Tour, lattice: &mut Lattice) {
        for leg in &mut tour.legs {
            if leg.path.len() <= 2 || self.budget.late() {
                continue;
            }
            let (from, to) = (leg.path[0], leg.path[leg.path.len() - 1]);
            if let Some(path) = self.lattice_way(lattice, from, to) {
                if self.cost(&path) < self.cost(&leg.path) {
                    leg.path = path;
                }
            }
        }
    }

    /// The best order by the lattice's ways between stops, taken when that tour is shorter.
    fn reorder(&mut self, tour: &mut Tour, lattice: &mut Lattice) {
        let stops = tour.stops.clone();
        let mut paths: BTreeMap<(usize, usize), Vec<Point>> = BTreeMap::new();
        // What the tour has already may be shorter than what the lattice can say.
        let mut from = 0usize;
        for leg in &tour.legs {
            let to = 1 + tour.visits.iter().position(|&v| v == leg.goal).unwrap_or(0);
            let path = leg.path.clone();
            let path = if from < to { path } else { reversed(path) };
            paths.insert((from.min(to), from.max(to)), path);
            from = to;
        }
        let order = order::lazily(straight(&stops), |from, to| {
            let key = (from.min(to), from.max(to));
            let known = paths.get(&key).map(|path| path_length(path));
            if self.budget.late() {
                return known.unwrap_or(f64::INFINITY);
            }
            let way = self.lattice_way(lattice, stops[key.0], stops[key.1]);
            let length = way.as_deref().map_or(f64::INFINITY, path_length);
            if let Some(path) = way.filter(|_| known.is_none_or(|known| length < known)) {
                paths.insert(key, path);
            }
            length.min(known.unwrap_or(f64::INFINITY))
        });
        let mut legs = Vec::new();
        let mut from = 0usize;
        for to in order {
            let Some(path) = paths.get(&(from.min(to), from.max(to))).cloned() else {
                return;
            };
            legs.push(Leg {
                goal: tour.visits[to - 1],
                path: if from < to { path } else { reversed(path) },
            });
            from = to;
        }
        let total = |legs: &[Leg]| -> f64 { legs.iter().map(|leg| self.cost(&leg.path)).sum() };
        if total(&legs) < total(&tour.legs) {
            tour.legs = legs;
        }
    }
}

fn reversed(mut path: Vec<Point>) -> Vec<Point> {
    path.reverse();
    path
}

/// Straight distances between all stops: no leg is shorter.
fn straight(stops: &[Point]) -> Vec<Vec<f64>> {
    stops
        .iter()
        .map(|&a| stops.iter().map(|&b| distance(a, b)).collect())
        .collect()
}

/// A valid way through the tree between two stops (0 is the start).
fn raw_leg(stops: &Stops, grown: &Grown, from: usize, to: usize) -> Vec<Point> {
    let node = |stop: usize| match stop {
        0 => 0,
        // Only goals that the tree has reached are visited.
        stop => grown.reached[stops.visits[stop - 1]].unwrap_or(0),
    };
    grown.tree.path_between(node(from), node(to))
}
