//! The interior-point method that finds the energies: primal-dual, with predictor and corrector.

use super::banded::Pentadiagonal;
use super::limits::Limits;
use super::rows::{apply, push_rows, Bend, Row, Stencil};

/// Steps at most, and the gap as a share of the time at which the speed is the fastest.
const MAX_STEPS: usize = 30;
const GAP: f64 = 1e-3;
/// Of the way to the nearest limit, how much a step goes.
const TO_LIMIT: f64 = 0.99;
/// Seconds a metre that jerk at its limit costs, at a speed in m/s: where jerk gains next to nothing there is none, and
/// between the nodes it is not much more than at them.
const JERK_COST: f64 = 0.8;
const COST_SPEED: f64 = 0.2;
/// m²/s²: the least energy, and what no constant speed exceeds.
pub const LEAST: f64 = 1e-7;
/// Slacks of a start outside the limits, as a share of the limit, and what may be lacking of them at the end.
const SLACK: f64 = 0.05;
const LACKING: f64 = 2e-3;
/// How far all slacks, or all multipliers, may follow a step.
struct Room(f64);

impl Room {
    fn see(&mut self, value: f64, change: f64) {
        if change < 0.0 {
            self.0 = self.0.min(-value / change);
        }
    }

    fn share(&self) -> f64 {
        (TO_LIMIT * self.0).min(1.0)
    }
}

/// What the energies are found from.
pub struct Problem<'a> {
    /// The nodes.
    pub bend: &'a Bend<'a>,
    /// Of both axes.
    pub limits: &'a Limits,
    /// Stencils of the first derivative over arc length.
    pub first: &'a [Stencil],
    /// Of the second.
    pub second: &'a [Stencil],
    /// The most energy at each node; none where the rover rests.
    pub top: &'a [f64],
}

/// Energies on their way to the fastest.
pub struct Solver {
    rows: Vec<Row>,
    /// Metres of the path that each node stands for.
    weight: Vec<f64>,
    energy: Vec<f64>,
    /// Nodes whose energy is given: ends at rest, or beyond those that are sought.
    fixed: Vec<bool>,
    matrix: Pentadiagonal,
}

impl Solver {
    /// From a constant speed that keeps every limit with room to spare.
    pub fn new(problem: &Problem) -> Self {
        let top = problem.top;
        let fixed: Vec<bool> = top.iter().map(|&e| e <= LEAST).collect();
        let lowest = top.iter().zip(&fixed).filter(|(_, &fixed)| !fixed);
        let mut least = lowest.fold(f64::INFINITY, |least, (&e, _)| least.min(e)) / 2.0;
        let mut solver = Self::with(problem, vec![0.0; top.len()], fixed);
        loop {
            for (e, &fixed) in solver.energy.iter_mut().zip(&solver.fixed) {
                *e = if fixed { 0.0 } else { least };
            }
            if solver.see_slacks() || least < LEAST {
                return solver;
            }
            least *= 0.6;
        }
    }

    /// From energies that may be outside the limits; what is `fixed` stays.
    pub fn from(problem: &Problem, energy: Vec<f64>, mut fixed: Vec<bool>) -> Self {
        for (fixed, &e) in fixed.iter_mut().zip(problem.top) {
            *fixed |= e <= LEAST;
        }
        let mut solver = Self::with(problem, energy, fixed);
        solver.see_slacks();
        for row in &mut solver.rows {
            let bound = (row.slack[0] + row.lack[0] + row.slack[1] + row.lack[1]) / 2.0;
            for side in 0..2 {
                let real = row.slack[side] + row.lack[side];
                row.slack[side] = real.max(SLACK * bound);
                row.lack[side] = real - row.slack[side];
            }
        }
        solver
    }

    fn with(problem: &Problem, energy: Vec<f64>, fixed: Vec<bool>) -> Self {
        let (bend, limits, nodes) = (problem.bend, problem.limits, energy.len());
        let mut rows = Vec::with_capacity(6 * nodes);
        for i in 0..nodes {
            let free = |node: Option<&bool>| node == Some(&false);
            let beside = (i > 0 && free(fixed.get(i - 1))) || free(fixed.get(i + 1));
            if !fixed[i] || (energy[i] > LEAST && beside) {
                let stencils = (&problem.first[i], &problem.second[i]);
                push_rows(&mut rows, bend, limits, stencils, problem.top[i], i);
            }
        }
        for row in &mut rows {
            row.fix(&fixed, &energy);
        }
        rows.retain(|row| row.stencil.iter().any(|c| *c != 0.0));
        let mut weight = vec![0.0; nodes];
        for (i, h) in bend.length.iter().enumerate() {
            weight[i] += h / 2.0;
            weight[i + 1] += h / 2.0;
        }
        for row in rows.iter_mut().filter(|row| row.jerk) {
            row.cost = 2.0 * JERK_COST * weight[row.node] * (COST_SPEED / row.limit).powi(2);
        }
        for (weight, _) in weight.iter_mut().zip(&fixed).filter(|(_, fixed)| **fixed) {
            *weight = 0.0;
        }
        Self {
            rows,
            weight,
            energy,
            fixed,
            matrix: Pentadiagonal::zeros(nodes),
        }
    }

    /// The slacks at the energies now; whether all are positive. Where some of a slack is lacking, how much now.
    fn see_slacks(&mut self) -> bool {
        let mut inside = true;
        for row in &mut self.rows {
            let e = self.energy[row.node];
            let value = row.offset + apply(&row.stencil, &self.energy, row.node);
            let mut bound = row.limit;
            if row.jerk {
                bound /= (2.0 * e).sqrt();
                let moves = !self.fixed[row.node];
                row.slope = if moves { -bound / (2.0 * e) } else { 0.0 };
            }
            for (side, real) in [bound - value, bound + value].into_iter().enumerate() {
                if row.lack[side] == 0.0 || real >= row.slack[side] {
                    (row.slack[side], row.lack[side]) = (real, 0.0);
                } else {
                    row.lack[side] = real - row.slack[side];
                }
                inside &= row.slack[side] > 0.0;
            }
        }
        inside
    }

    /// The most that is lacking of any slack, as a share of the slack and more.
    fn lacking(&self) -> f64 {
        let each = |row: &Row| {
            let bound = (row.slack[0] + row.slack[1]) / 2.0;
            (-row.lack[0]).max(-row.lack[1]) / bound
        };
        self.rows.iter().map(each).fold(0.0, f64::max)
    }

    fn time(&self) -> f64 {
        let each = self
            .weight
            .iter()
            .zip(&self.energy)
            .filter(|(_, &e)| e > 0.0);
        each.map(|(w, e)| w / (2.0 * e).sqrt()).sum()
    }

    /// What time and jerk cost less with more of each energy, and Σ of the gradients of all slacks with these weights.
    fn force(&self, weight: impl Fn(&Row, usize) -> f64) -> Vec<f64> {
        let of_time = |(w, &e): (&f64, &f64)| {
            if e > 0.0 {
                w / (2.0 * e * (2.0 * e).sqrt())
            } else {
                0.0
            }
        };
        let mut found: Vec<f64> = self.weight.iter().zip(&self.energy).map(of_time).collect();
        for row in &self.rows {
            let (above, below, i) = (weight(row, 0), weight(row, 1), row.node);
            let across = below - above - row.cost * (row.slack[1] - row.slack[0]) / 2.0;
            if i > 0 {
                found[i - 1] += row.stencil[0] * across;
            }
            found[i] += row.slope * (above + below) + row.stencil[1] * across;
            if i + 1 < found.len() {
                found[i + 1] += row.stencil[2] * across;
            }
        }
        found
    }

    fn assemble(&mut self) {
        self.matrix.clear();
        let [main, first, second] = &mut self.matrix.diagonals;
        for (i, (w, &e)) in self.weight.iter().zip(&self.energy).enumerate() {
            let v2 = 2.0 * e;
            main[i] = if self.fixed[i] {
                1.0
            } else {
                3.0 * w / (v2 * v2 * v2.sqrt())
            };
        }
        for row in &self.rows {
            let (i, [left, middle, right]) = (row.node, row.stencil);
            let (above, below) = (row.held[0] / row.slack[0], row.held[1] / row.slack[1]);
            let (both, across) = (above + below, row.slope * (below - above));
            main[i] += both * row.slope * row.slope + 2.0 * across * middle;
            let both = both + row.cost;
            main[i] += both * middle * middle;
            if i > 0 {
                main[i - 1] += both * left * left;
                first[i - 1] += left * (both * middle + across);
                second[i - 1] += both * left * right;
            }
            if i + 1 < self.energy.len() {
                main[i + 1] += both * right * right;
                first[i] += right * (both * middle + across);
            }
        }
        self.matrix.factor();
    }

    /// Changes of slacks and multipliers with a step; `aim`: what each product of the two is to become.
    fn follow(&mut self, step: &[f64], aim: impl Fn(&Row, usize) -> f64) -> (f64, f64) {
        let (mut room, mut room_held) = (Room(f64::INFINITY), Room(f64::INFINITY));
        for row in &mut self.rows {
            let value = apply(&row.stencil, step, row.node);
            let bound = row.slope * step[row.node];
            let aims = [aim(row, 0), aim(row, 1)];
            row.change = [bound - value + row.lack[0], bound + value + row.lack[1]];
            for (side, aim) in aims.iter().enumerate() {
                let (s, z) = (row.slack[side], row.held[side]);
                row.change_held[side] = (aim - z * row.change[side]) / s - z;
                room.see(s, row.change[side]);
                room_held.see(z, row.change_held[side]);
            }
        }
        (room.share(), room_held.share())
    }

    /// The energies, and whether they keep the limits.
    pub fn solve(mut self) -> (Vec<f64>, bool) {
        let sides = 2.0 * self.rows.len() as f64;
        let begin = self.time() / sides;
        for row in &mut self.rows {
            row.held = row.slack.map(|s| begin / s);
        }
        for _ in 0..MAX_STEPS {
            let off = self.force(|row, side| row.held[side]);
            let off: f64 = off.iter().zip(&self.energy).map(|(r, e)| r.abs() * e).sum();
            let both = |f: fn(&Row, usize) -> f64| {
                self.rows
                    .iter()
                    .map(|row| f(row, 0) + f(row, 1))
                    .sum::<f64>()
            };
            let gap = both(|row, side| row.slack[side] * row.held[side]);
            if gap.max(off) < GAP * self.time() && self.lacking() < LACKING {
                break;
            }
            self.assemble();
            // Predictor: as if the limits were to be reached at once.
            let lack = |row: &Row, side: usize| row.held[side] * row.lack[side];
            let mut step = self.force(|row, side| -lack(row, side) / row.slack[side]);
            self.matrix.solve(&mut step);
            let (reach, reach_held) = self.follow(&step, |_, _| 0.0);
            let ahead: f64 = self
                .rows
                .iter()
                .map(|row| row.product(0, reach, reach_held) + row.product(1, reach, reach_held))
                .sum();
            // No nearer to the limits than the multipliers are to balance.
            let centre = ((ahead / gap).clamp(0.0, 1.0).powi(3) * gap).max(off) / sides;
            let aim = |row: &Row, side: usize| centre - row.change[side] * row.change_held[side];
            let mut step =
                self.force(|row, side| (aim(row, side) - lack(row, side)) / row.slack[side]);
            self.matrix.solve(&mut step);
            let (mut reach, reach_held) = self.follow(&step, aim);
            for ((e, d), &fixed) in self.energy.iter().zip(&step).zip(&self.fixed) {
                if *d < 0.0 && !fixed {
                    reach = reach.min(-0.9 * e / d);
                }
            }
            for ((e, d), &fixed) in self.energy.iter_mut().zip(&step).zip(&self.fixed) {
                if !fixed {
                    *e += reach * d;
                }
            }
            for row in &mut self.rows {
                for side in 0..2 {
                    row.slack[side] += reach * row.change[side];
                    row.held[side] += reach_held * row.change_held[side];
                }
            }
            self.see_slacks();
        }
        let kept = self.lacking() < LACKING;
        (self.energy, kept)
    }
}
