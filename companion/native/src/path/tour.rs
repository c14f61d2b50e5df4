//! A tour: stops and the legs between them.

use std::time::Instant;

use crate::geometry::{distance, Point};

/// The path to one goal.
pub struct Leg {
    /// The goal's number in the request.
    pub goal: usize,
    /// From the stop before, both ends included.
    pub path: Vec<Point>,
}

/// Legs in order of visit.
pub struct Tour {
    /// The start, and the goals that can be reached.
    pub stops: Vec<Point>,
    /// The numbers of those goals in the request.
    pub visits: Vec<usize>,
    /// One a visit.
    pub legs: Vec<Leg>,
    /// When the first valid tour was known.
    pub first: Instant,
}

impl Tour {
    /// A tour through all `goals` whose legs are known already.
    pub fn known(start: Point, goals: &[Point], legs: Vec<Leg>) -> Self {
        Self {
            stops: [&[start], goals].concat(),
            visits: (0..goals.len()).collect(),
            legs,
            first: Instant::now(),
        }
    }

    /// True when a leg is not a straight line.
    pub fn is_winding(&self) -> bool {
        self.legs.iter().any(|leg| leg.path.len() > 2)
    }
}

/// The same path backwards.
pub fn reversed(mut path: Vec<Point>) -> Vec<Point> {
    path.reverse();
    path
}

/// Straight distances between all stops: no leg is shorter.
pub fn straight_distances(stops: &[Point]) -> Vec<Vec<f64>> {
    stops
        .iter()
        .map(|&a| stops.iter().map(|&b| distance(a, b)).collect())
        .collect()
}
