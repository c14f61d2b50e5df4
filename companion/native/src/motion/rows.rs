//! Limits along a bend as rows over the energies at its nodes.

use super::limits::Limits;

/// Of the energy that a jump from rest may reach at the first node: its jerk differs between nodes.
const FROM_REST: f64 = 0.9;

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
pub type Stencil = [f64; 3];

/// Stencils of the first and second derivative over arc length. At both ends the acceleration is zero.
pub fn derivatives(length: &[f64]) -> (Vec<Stencil>, Vec<Stencil>) {
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

/// The stencil's value at node `i`.
pub fn apply(stencil: &Stencil, values: &[f64], i: usize) -> f64 {
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
pub fn caps(bend: &Bend, limits: &Limits) -> Vec<f64> {
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

/// |stencil · e| ≤ limit, or limit / v.
pub struct Row {
    /// In the middle of its stencil.
    pub node: usize,
    /// Over the energies.
    pub stencil: Stencil,
    /// Of its value, or of that times the speed.
    pub limit: f64,
    /// Whether the speed counts.
    pub jerk: bool,
    /// What fixed neighbours add.
    pub offset: f64,
    /// On both sides, what is left to the limit.
    pub slack: [f64; 2],
    /// What the slacks are less than is asked of them, while a start outside the limits is made good.
    pub lack: [f64; 2],
    /// Their multipliers.
    pub held: [f64; 2],
    /// What a step changes the slacks by.
    pub change: [f64; 2],
    /// And the multipliers.
    pub change_held: [f64; 2],
    /// Of the limit over the energy of its node.
    pub slope: f64,
    /// What half of its square costs.
    pub cost: f64,
}

impl Row {
    /// Slack times multiplier after a step.
    pub fn product(&self, side: usize, reach: f64, reach_held: f64) -> f64 {
        (self.slack[side] + reach * self.change[side])
            * (self.held[side] + reach_held * self.change_held[side])
    }

    /// Energies of fixed nodes become part of its offset.
    pub fn fix(&mut self, fixed: &[bool], energy: &[f64]) {
        for (place, coefficient) in self.stencil.iter_mut().enumerate() {
            let node = (self.node + place).wrapping_sub(1);
            if node < fixed.len() && fixed[node] {
                self.offset += *coefficient * energy[node];
                *coefficient = 0.0;
            }
        }
    }
}

/// Adds the rows of one node.
pub fn push_rows(
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
                offset: 0.0,
                slack: [0.0; 2],
                lack: [0.0; 2],
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
