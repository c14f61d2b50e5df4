//! The legs between the stops of a plan: chosen, ordered, and improved one by one.

use std::time::Instant;

use crate::budget::Budget;
use crate::connect;
use crate::field::Field;
use crate::geometry::{distance, path_length, Point};
use crate::lattice::Lattice;
use crate::order;
use crate::random::Random;
use crate::rrt::{Grown, Growth};
use crate::shorten::{self, Shortening};

/// What the first search found.
pub struct Stops {
    pub start: Point,
    /// Goals with a way, in the order in which they were asked for or, staged, visited.
    pub visits: Vec<usize>,
    /// Per visit: the way from the start (one tree) or from the visit before (staged).
    pub ways: Vec<Vec<Point>>,
    /// The one tree; none when the search was staged.
    pub grown: Option<Grown>,
    pub nodes: usize,
}

pub struct Leg {
    pub goal: usize,
    pub path: Vec<Point>,
}

pub struct Tour {
    pub legs: Vec<Leg>,
    pub nodes: usize,
    /// When the first valid tour was known.
    pub first: Instant,
}

/// Tree extensions that a leg of its own may take.
const LEG_TRIES: u64 = 400;
/// Cells above which the lattice costs more than it brings to a leg that already has a path.
const LATTICE_CELLS: usize = 60_000;

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
    pub fn tour(&mut self, stops: &Stops, any_order: bool) -> Tour {
        let first = Instant::now();
        let mut tour = Tour {
            legs: Vec::new(),
            nodes: 0,
            first,
        };
        let Some(grown) = &stops.grown else {
            for (&goal, way) in stops.visits.iter().zip(&stops.ways) {
                let mut path = way.clone();
                shorten::settle(self.field, &mut path, self.shortening, 3);
                tour.legs.push(Leg { goal, path });
            }
            return tour;
        };
        let count = stops.visits.len();
        let mut sequence: Vec<usize> = (0..count).collect();
        let mut table: Vec<Vec<Option<Vec<Point>>>> = vec![vec![None; count + 1]; count + 1];
        if any_order && count > 1 {
            let mut lengths = vec![vec![0.0; count + 1]; count + 1];
            for to in 1..=count {
                for from in 0..to {
                    let (path, nodes) = self.better_of(raw_leg(stops, grown, from, to));
                    tour.nodes += nodes;
                    lengths[from][to] = path_length(&path);
                    lengths[to][from] = lengths[from][to];
                    table[from][to] = Some(path);
                }
            }
            sequence = order::order(&lengths)
                .iter()
                .map(|&stop| stop - 1)
                .collect();
        }
        let mut from = 0usize;
        for visit in sequence {
            let to = visit + 1;
            let path = if let Some(path) = table[from][to].take() {
                path
            } else if let Some(mut path) = table[to][from].take() {
                path.reverse();
                path
            } else {
                let (path, nodes) = self.better_of(raw_leg(stops, grown, from, to));
                tour.nodes += nodes;
                path
            };
            tour.legs.push(Leg {
                goal: stops.visits[visit],
                path,
            });
            from = to;
        }
        tour
    }

    /// Restarts and shortcuts, leg by leg, until the budget is spent or every leg is a straight line.
    pub fn improve(&mut self, tour: &mut Tour) {
        let lattice = Lattice::new(self.field, self.field.lattice_spacing());
        let mut round = 0usize;
        let mut best: Vec<f64> = tour.legs.iter().map(|leg| self.cost(&leg.path)).collect();
        while !self.budget.exhausted()
            && !self.budget.late()
            && tour.legs.iter().any(|leg| leg.path.len() > 2)
        {
            for (leg, best) in tour.legs.iter_mut().zip(&mut best) {
                if leg.path.len() <= 2 || !self.budget.spend() {
                    continue;
                }
                let (from, to) = (leg.path[0], leg.path[leg.path.len() - 1]);
                let candidate = if round == 0 {
                    Some(leg.path.clone())
                } else if round == 1 && lattice.size() <= LATTICE_CELLS {
                    let budget = &*self.budget;
                    lattice
                        .paths(self.field, from, &[to], self.shortening.radius, || {
                            budget.late()
                        })
                        .pop()
                        .flatten()
                } else if round % 4 == 3 {
                    let mut path = leg.path.clone();
                    shorten::random_shortcuts(
                        self.field,
                        &mut path,
                        self.shortening,
                        16,
                        self.random,
                        self.budget,
                    );
                    Some(path)
                } else {
                    let (path, nodes) = self.restart(from, to);
                    tour.nodes += nodes;
                    path.filter(|path| self.cost(path) < 1.1 * *best)
                };
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
}

/// A valid way between two stops (0 is the start): through the tree, or back to the start and out again.
fn raw_leg(stops: &Stops, grown: &Grown, from: usize, to: usize) -> Vec<Point> {
    let node = |stop: usize| match stop {
        0 => Some(0),
        stop => grown.reached[stops.visits[stop - 1]],
    };
    if let (Some(a), Some(b)) = (node(from), node(to)) {
        return grown.tree.path_between(a, b);
    }
    let way = |stop: usize| match stop {
        0 => vec![stops.start],
        stop => stops.ways[stop - 1].clone(),
    };
    let mut path = way(from);
    path.reverse();
    for p in way(to) {
        if path.last().is_none_or(|&last| distance(last, p) > 0.0) {
            path.push(p);
        }
    }
    path
}
