//! The fastest speed along a bend within acceleration and jerk of both axes, by an interior-point method.
//!
//! In the energy e = v²/2 over arc length s the acceleration is e′ and the jerk v e″. With the curvature κ of the bend the
//! heading has
//!
//! ```text
//! acceleration  2 κ′ e + κ e′          jerk  v (2 κ″ e + 3 κ′ e′ + κ e″)
//! ```
//!
//! so every limit is |linear in e| ≤ L or ≤ L / v, each row a stencil of three neighbouring nodes. 1/v is convex in e: its
//! tangent lies below, so a step that keeps the limits linearised where it begins keeps the limits. The time Σ w / v is
//! convex, too. Each step costs one pentadiagonal system: the time is linear in the number of nodes.
//! Predictor and corrector as in Mehrotra, On the implementation of a primal-dual interior point method (1992).

use super::banded::Pentadiagonal;
use super::limits::Limits;

/// Steps at most, and the gap as a share of the time at which the speed is the fastest.
const MAX_STEPS: usize = 30;
const GAP: f64 = 1e-3;
/// Of the way to the nearest limit, how much a step goes.
const TO_LIMIT: f64 = 0.99;
/// Of the energy that a jump from rest may reach at the first node: its jerk differs between nodes.
const FROM_REST: f64 = 0.9;
/// Seconds a metre that jerk at its limit costs, at a speed in m/s: where jerk gains next to nothing there is none, and
/// between the nodes it is not much more than at them.
const JERK_COST: f64 = 0.8;
const COST_SPEED: f64 = 0.2;
/// m²/s²: the least energy, and what no constant speed exceeds.
const LEAST: f64 = 1e-7;
/// The nodes of a bend, N + 1 of them between N curves.
pub struct Bend<'a> {
    /// Of each curve, metres, N.
    pub length: &'a [f64],
    /// At each node, 1/m and 1/m².
    pub curvature: &'a [f64],
    /// Its slope over arc length, 1/m².
    pub slope: &'a [f64],
    /// Second derivative of curvature on the last part before each node and on the first behind it, 1/m³.
    pub before: &'a [f64],
    /// Behind it.
    pub behind: &'a [f64],
    /// Most speed at each node; 0 at an end where the rover rests.
    pub most: &'a [f64],
    /// Share of the limits of acceleration and jerk at each node.
    pub share: &'a [f64],
}

/// Three coefficients, over the node before, the node and the one behind.
type Stencil = [f64; 3];

/// Speeds and accelerations at the nodes.
pub fn fastest(bend: &Bend, limits: &Limits) -> (Vec<f64>, Vec<f64>) {
    let nodes = bend.most.len();
    let (first, second) = derivatives(bend.length);
    let top = caps(bend, limits);
    let energy = if top.iter().all(|&each| each <= LEAST) {
        top
    } else {
        Solver::new(bend, limits, &first, &second, &top).solve()
    };
    let speed: Vec<f64> = energy.iter().map(|e| (2.0 * e).sqrt()).collect();
    let acceleration = (0..nodes).map(|i| apply(&first[i], &energy, i)).collect();
    (speed, acceleration)
}

/// Stencils of the first and second derivative over arc length. At both ends the acceleration is zero.
fn derivatives(length: &[f64]) -> (Vec<Stencil>, Vec<Stencil>) {
    let nodes = length.len() + 1;
    let mut first = vec![[0.0; 3]; nodes];
    let mut second = vec![[0.0; 3]; nodes];
    for i in 1..nodes - 1 {
        let (a, b) = (length[i - 1], length[i]);
        first[i] = [-b / (a * (a + b)), (b - a) / (a * b), a / (b * (a + b))];
        second[i] = [2.0 / (a * (a + b)), -2.0 / (a * b), 2.0 / (b * (a + b))];
    }
    let (a, b) = (length[0], length[nodes - 2]);
    second[0] = [0.0, -2.0 / (a * a), 2.0 / (a * a)];
    second[nodes - 1] = [2.0 / (b * b), -2.0 / (b * b), 0.0];
    (first, second)
}

fn apply(stencil: &Stencil, values: &[f64], i: usize) -> f64 {
    let mut sum = stencil[1] * values[i];
    if i > 0 {
        sum += stencil[0] * values[i - 1];
    }
    if i + 1 < values.len() {
        sum += stencil[2] * values[i + 1];
    }
    sum
}

/// The most energy at each node: of its most speed, and of what is reached from rest.
fn caps(bend: &Bend, limits: &Limits) -> Vec<f64> {
    let mut found: Vec<f64> = bend.most.iter().map(|v| v * v / 2.0).collect();
    let nodes = found.len();
    if bend.most[0] <= 0.0 {
        found[1] = found[1].min(FROM_REST * from_rest(bend.length[0], limits, bend.share[1]));
    }
    if bend.most[nodes - 1] <= 0.0 {
        let reached = from_rest(bend.length[nodes - 2], limits, bend.share[nodes - 2]);
        found[nodes - 2] = found[nodes - 2].min(FROM_REST * reached);
    }
    found
}

/// The most energy within a way from rest: jerk, then constant acceleration.
fn from_rest(way: f64, limits: &Limits, share: f64) -> f64 {
    let (a, j) = (
        share * limits.travel.acceleration,
        share * limits.travel.jerk,
    );
    let rise = a.powi(3) / (6.0 * j * j);
    if way > rise {
        (a * a / (2.0 * j)).powi(2) / 2.0 + a * (way - rise)
    } else {
        (j * (6.0 * way / j).cbrt().powi(2) / 2.0).powi(2) / 2.0
    }
}

/// |stencil · e| ≤ limit, or limit / v. Both sides: the slack, its multiplier, and what a step changes them by.
struct Row {
    node: usize,
    stencil: Stencil,
    limit: f64,
    jerk: bool,
    slack: [f64; 2],
    held: [f64; 2],
    change: [f64; 2],
    change_held: [f64; 2],
    /// Of the limit over the energy of its node.
    slope: f64,
    /// What half of its square costs.
    cost: f64,
}

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

struct Solver {
    rows: Vec<Row>,
    /// Metres of the path that each node stands for.
    weight: Vec<f64>,
    energy: Vec<f64>,
    /// Nodes whose energy is none: ends at rest.
    fixed: Vec<bool>,
    matrix: Pentadiagonal,
}

impl Solver {
    fn new(
        bend: &Bend,
        limits: &Limits,
        first: &[Stencil],
        second: &[Stencil],
        top: &[f64],
    ) -> Self {
        let nodes = top.len();
        let fixed: Vec<bool> = top.iter().map(|&e| e <= LEAST).collect();
        let mut rows = Vec::with_capacity(6 * nodes);
        for i in (0..nodes).filter(|&i| !fixed[i]) {
            push_rows(&mut rows, bend, limits, (&first[i], &second[i]), top[i], i);
        }
        for row in &mut rows {
            if row.node > 0 && fixed[row.node - 1] {
                row.stencil[0] = 0.0;
            }
            if row.node + 1 < nodes && fixed[row.node + 1] {
                row.stencil[2] = 0.0;
            }
        }
        let mut weight = vec![0.0; nodes];
        for (i, h) in bend.length.iter().enumerate() {
            weight[i] += h / 2.0;
            weight[i + 1] += h / 2.0;
        }
        let lowest = top.iter().zip(&fixed).filter(|(_, &fixed)| !fixed);
        let mut least = lowest.fold(f64::INFINITY, |least, (&e, _)| least.min(e)) / 2.0;
        let mut solver = Self {
            rows,
            weight,
            energy: vec![0.0; nodes],
            fixed,
            matrix: Pentadiagonal::zeros(nodes),
        };
        for row in solver.rows.iter_mut().filter(|row| row.jerk) {
            row.cost = 2.0 * JERK_COST * solver.weight[row.node] * (COST_SPEED / row.limit).powi(2);
        }
        // A constant speed that keeps every limit with room to spare.
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

    /// The slacks at the energies now; whether all are positive.
    fn see_slacks(&mut self) -> bool {
        let mut inside = true;
        for row in &mut self.rows {
            let (value, e) = (
                apply(&row.stencil, &self.energy, row.node),
                self.energy[row.node],
            );
            let mut bound = row.limit;
            if row.jerk {
                bound /= (2.0 * e).sqrt();
                row.slope = -bound / (2.0 * e);
            }
            row.slack = [bound - value, bound + value];
            inside &= row.slack[0] > 0.0 && row.slack[1] > 0.0;
        }
        inside
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
            row.change = [bound - value, bound + value];
            for (side, aim) in aims.iter().enumerate() {
                let (s, z) = (row.slack[side], row.held[side]);
                row.change_held[side] = (aim - z * row.change[side]) / s - z;
                room.see(s, row.change[side]);
                room_held.see(z, row.change_held[side]);
            }
        }
        (room.share(), room_held.share())
    }

    fn solve(mut self) -> Vec<f64> {
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
            if gap.max(off) < GAP * self.time() {
                break;
            }
            self.assemble();
            // Predictor: as if the limits were to be reached at once.
            let mut step = self.force(|_, _| 0.0);
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
            let mut step = self.force(|row, side| aim(row, side) / row.slack[side]);
            self.matrix.solve(&mut step);
            let (mut reach, reach_held) = self.follow(&step, aim);
            for (e, d) in self.energy.iter().zip(&step) {
                if *d < 0.0 && *e > 0.0 {
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
                    row.held[side] += reach_held * row.change_held[side];
                }
            }
            self.see_slacks();
        }
        self.energy
    }
}

impl Row {
    fn product(&self, side: usize, reach: f64, reach_held: f64) -> f64 {
        (self.slack[side] + reach * self.change[side])
            * (self.held[side] + reach_held * self.change_held[side])
    }
}

fn push_rows(
    rows: &mut Vec<Row>,
    bend: &Bend,
    limits: &Limits,
    (first, second): (&Stencil, &Stencil),
    top: f64,
    i: usize,
) {
    let (travel, heading, share) = (limits.travel, limits.heading, bend.share[i]);
    let (curvature, slope) = (bend.curvature[i], bend.slope[i]);
    let sum = |middle: f64, once: f64, twice: f64| {
        [
            once * first[0] + twice * second[0],
            middle + once * first[1] + twice * second[1],
            once * first[2] + twice * second[2],
        ]
    };
    let mut add = |stencil: Stencil, limit: f64, jerk: bool| {
        if stencil.iter().any(|c| c.abs() > 1e-9) {
            rows.push(Row {
                node: i,
                stencil,
                limit,
                jerk,
                slack: [0.0; 2],
                held: [0.0; 2],
                change: [0.0; 2],
                change_held: [0.0; 2],
                slope: 0.0,
                cost: 0.0,
            });
        }
    };
    add([0.0, 1.0, 0.0], top, false);
    add(*first, share * travel.acceleration, false);
    add(*second, share * travel.jerk, true);
    add(
        sum(2.0 * slope, curvature, 0.0),
        share * heading.acceleration,
        false,
    );
    let thirds = [bend.before[i], bend.behind[i]];
    for third in &thirds[..if thirds[0] == thirds[1] { 1 } else { 2 }] {
        add(
            sum(2.0 * third, 3.0 * slope, curvature),
            share * heading.jerk,
            true,
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::limits::Axis;

    const LIMITS: Limits = Limits {
        travel: Axis {
            acceleration: 0.5,
            jerk: 3.0,
        },
        heading: Axis {
            acceleration: 3.0,
            jerk: 8.0,
        },
    };

    /// A bump of curvature in the middle of 2 m: its size, slope and the derivative of that at each node.
    fn bump(height: f64) -> (Vec<f64>, [Vec<f64>; 4]) {
        let (nodes, h) = (81, 0.025);
        let wave = |i: usize| std::f64::consts::PI * ((i as f64 * h - 0.5).clamp(0.0, 1.0));
        let rate = std::f64::consts::TAU;
        let of = |f: &dyn Fn(f64) -> f64| {
            (0..nodes)
                .map(|i| height / 2.0 * f(2.0 * wave(i)))
                .collect::<Vec<_>>()
        };
        let third = of(&|x| {
            if x > 0.0 && x < rate {
                rate * rate * x.cos()
            } else {
                0.0
            }
        });
        let columns = [
            of(&|x| 1.0 - x.cos()),
            of(&|x| rate * x.sin()),
            third.clone(),
            third,
        ];
        (vec![h; nodes - 1], columns)
    }

    fn solved(height: f64, most: f64, limits: &Limits) -> (Vec<f64>, Vec<f64>) {
        let (length, [curvature, slope, before, behind]) = bump(height);
        let mut top = vec![most; length.len() + 1];
        top[0] = 0.0;
        let share = vec![1.0; top.len()];
        let bend = Bend {
            length: &length,
            curvature: &curvature,
            slope: &slope,
            before: &before,
            behind: &behind,
            most: &top,
            share: &share,
        };
        fastest(&bend, limits)
    }

    #[test]
    fn a_straight_way_is_driven_at_the_most_speed_but_for_its_beginning() {
        let (speed, acceleration) = solved(0.0, 0.25, &LIMITS);
        assert_eq!(speed[0], 0.0);
        assert!(speed[10..].iter().all(|v| *v > 0.249 && *v <= 0.25));
        assert!(acceleration
            .iter()
            .all(|a| a.abs() <= LIMITS.travel.acceleration));
    }

    #[test]
    fn a_tight_place_costs_something_there_only_and_no_limit_is_exceeded() {
        let (height, h) = (40.0, 0.025);
        let (speed, acceleration) = solved(height, 0.25, &LIMITS);
        let (_, [curvature, slope, third, _]) = bump(height);
        let slowest = speed[20..].iter().copied().fold(1.0, f64::min);
        assert!(slowest < 0.2 && speed[10] > 0.249 && speed[70] > 0.249);
        for i in 2..speed.len() - 1 {
            let (v, a) = (speed[i], acceleration[i]);
            let energy = |k: usize| speed[k] * speed[k] / 2.0;
            let change = (energy(i + 1) - 2.0 * energy(i) + energy(i - 1)) / (h * h);
            let turn = slope[i] * v * v + curvature[i] * a;
            let jerk = v * (third[i] * v * v + 3.0 * slope[i] * a + curvature[i] * change);
            assert!(a.abs() < 0.501 && (v * change).abs() < 3.01, "{i}");
            assert!(turn.abs() < 3.01 && jerk.abs() < 8.01, "{i} {jerk}");
        }
        // Faster than the constant speed that turn acceleration allows.
        let constant = (3.0 / (height / 2.0 * std::f64::consts::TAU)).sqrt();
        let time = |speed: &dyn Fn(usize) -> f64| (11..70).map(|i| h / speed(i)).sum::<f64>();
        assert!(time(&|i| speed[i]) < time(&|_| constant));
    }
}
