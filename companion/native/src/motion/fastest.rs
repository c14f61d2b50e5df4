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

use super::interior_point::{Problem, Solver, LEAST};
use super::limits::Limits;
use super::rows::{apply, caps, derivatives, Bend};

/// Metres to both sides of what has changed that are solved anew: about what stopping and starting takes, twice.
const REACH_M: f64 = 0.6;
/// Where more than this share of the nodes is to be solved anew, all are.
const MOST_ANEW: f64 = 0.6;

/// What was found for the same curves with other speeds or shares allowed.
pub struct Former<'a> {
    /// Most speed at each node then.
    pub most: &'a [f64],
    /// Share of the limits then.
    pub share: &'a [f64],
    /// Speeds at the nodes.
    pub speed: &'a [f64],
}

/// Speeds and accelerations at the nodes. `former`: to begin with, where only few places are different.
pub fn fastest(bend: &Bend, limits: &Limits, former: Option<&Former>) -> (Vec<f64>, Vec<f64>) {
    let nodes = bend.most.len();
    let (first, second) = derivatives(bend.length);
    let top = caps(bend, limits);
    let problem = Problem {
        bend,
        limits,
        first: &first,
        second: &second,
        top: &top,
    };
    let energy = if top.iter().all(|&each| each <= LEAST) {
        top.clone()
    } else {
        former
            .and_then(|former| anew(&problem, former))
            .unwrap_or_else(|| Solver::new(&problem).solve().0)
    };
    let speed: Vec<f64> = energy.iter().map(|e| (2.0 * e).sqrt()).collect();
    let acceleration = (0..nodes).map(|i| apply(&first[i], &energy, i)).collect();
    (speed, acceleration)
}

/// The energies where only windows around what has changed are solved again, between nodes that stay as they were; none
/// where that is not found, or is most of the bend.
fn anew(problem: &Problem, former: &Former) -> Option<Vec<f64>> {
    let (bend, nodes) = (problem.bend, problem.top.len());
    let changed = |i: usize| bend.most[i] != former.most[i] || bend.share[i] != former.share[i];
    let mut energy: Vec<f64> = former.speed.iter().map(|v| v * v / 2.0).collect();
    let mut windows: Vec<[usize; 2]> = vec![];
    for i in (0..nodes).filter(|&i| changed(i)) {
        let (mut low, mut high) = (i, i);
        let (mut before, mut behind) = (0.0, 0.0);
        while low > 0 && before < REACH_M {
            low -= 1;
            before += bend.length[low];
        }
        while high + 1 < nodes && behind < REACH_M {
            behind += bend.length[high];
            high += 1;
        }
        match windows.last_mut() {
            Some(last) if low <= last[1] + 3 => last[1] = high,
            _ => windows.push([low, high]),
        }
    }
    let all: usize = windows.iter().map(|[low, high]| high + 1 - low).sum();
    if all as f64 > MOST_ANEW * nodes as f64 {
        return None;
    }
    for [low, high] in windows {
        // Two nodes on either side stay, so that speed and acceleration go on.
        let (begin, end) = (low.saturating_sub(2), (high + 3).min(nodes));
        let stays = |i: usize| (i < low && low > 1) || (i > high && high + 2 < nodes);
        let part = Bend {
            length: &bend.length[begin..end - 1],
            curvature: &bend.curvature[begin..end],
            slope: &bend.slope[begin..end],
            before: &bend.before[begin..end],
            behind: &bend.behind[begin..end],
            most: &bend.most[begin..end],
            share: &bend.share[begin..end],
        };
        let part = Problem {
            bend: &part,
            limits: problem.limits,
            first: &problem.first[begin..end],
            second: &problem.second[begin..end],
            top: &problem.top[begin..end],
        };
        let start = (begin..end)
            .map(|i| {
                if stays(i) || problem.top[i] <= LEAST {
                    energy[i]
                } else {
                    energy[i].min(0.95 * problem.top[i]).max(LEAST)
                }
            })
            .collect();
        let (found, kept) = Solver::from(&part, start, (begin..end).map(stays).collect()).solve();
        if !kept {
            return None;
        }
        energy[begin..end].copy_from_slice(&found);
    }
    Some(energy)
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
        fastest(&bend, limits, None)
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
