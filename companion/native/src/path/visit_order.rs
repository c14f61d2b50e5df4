//! In which order to visit the goals: exact (Held and Karp 1962) for few, nearest neighbour with 2-opt and Or-opt for many.

/// Goals up to which the order is exact.
const MAX_EXACT_GOALS: usize = 12;
/// Rounds of `lazily` for more goals than are ordered exactly.
const MAX_ROUNDS: usize = 40;
/// Metres that a change must save, and by which a leg must be longer than its bound to count.
const MIN_GAIN_M: f64 = 1e-9;
/// Goals in a stretch that Or-opt moves, at most.
const MAX_STRETCH: usize = 3;

/// `legs[i][j]`: length between stops, stop 0 is the start; infinite where there is no path. Returns the goals
/// (1-based stops) in order of visit. The tour is open: it ends wherever the last goal is.
pub fn order(legs: &[Vec<f64>]) -> Vec<usize> {
    let goals = legs.len() - 1;
    if goals <= 1 {
        return (1..=goals).collect();
    }
    if goals <= MAX_EXACT_GOALS {
        exact(legs)
    } else {
        heuristic(legs)
    }
}

/// The order when the length of a leg is expensive to know: unknown legs count as their lower `bounds` until a tour uses
/// them; then `evaluate` gives the true length. Up to `MAX_EXACT_GOALS` the result is the same as with every leg known
/// beforehand.
pub fn lazily(
    mut bounds: Vec<Vec<f64>>,
    mut evaluate: impl FnMut(usize, usize) -> f64,
) -> Vec<usize> {
    let stops = bounds.len();
    let mut known = vec![false; stops * stops];
    let mut rounds = 0usize;
    loop {
        let tour = order(&bounds);
        let mut surprised = false;
        let mut from = 0usize;
        for &to in &tour {
            if !known[from * stops + to] {
                let length = evaluate(from, to);
                surprised |= length > bounds[from][to] + MIN_GAIN_M;
                for (a, b) in [(from, to), (to, from)] {
                    bounds[a][b] = length;
                    known[a * stops + b] = true;
                }
            }
            from = to;
        }
        rounds += 1;
        if !surprised || (stops > MAX_EXACT_GOALS + 1 && rounds >= MAX_ROUNDS) {
            return tour;
        }
    }
}

fn exact(legs: &[Vec<f64>]) -> Vec<usize> {
    let goals = legs.len() - 1;
    let full = (1usize << goals) - 1;
    let mut best = vec![f64::INFINITY; (full + 1) * goals];
    let mut from = vec![usize::MAX; (full + 1) * goals];
    for goal in 0..goals {
        best[(1 << goal) * goals + goal] = legs[0][goal + 1];
    }
    for set in 1..=full {
        for last in 0..goals {
            let here = best[set * goals + last];
            if set & (1 << last) == 0 || !here.is_finite() {
                continue;
            }
            for next in 0..goals {
                if set & (1 << next) != 0 {
                    continue;
                }
                let slot = (set | 1 << next) * goals + next;
                let through = here + legs[last + 1][next + 1];
                if through < best[slot] {
                    best[slot] = through;
                    from[slot] = last;
                }
            }
        }
    }
    let mut last = 0;
    for goal in 1..goals {
        if best[full * goals + goal] < best[full * goals + last] {
            last = goal;
        }
    }
    let mut set = full;
    let mut tour = Vec::with_capacity(goals);
    while last != usize::MAX && set != 0 {
        tour.push(last + 1);
        let before = from[set * goals + last];
        set &= !(1 << last);
        last = before;
    }
    tour.reverse();
    if tour.len() == goals {
        tour
    } else {
        (1..=goals).collect()
    }
}

fn heuristic(legs: &[Vec<f64>]) -> Vec<usize> {
    let goals = legs.len() - 1;
    let mut tour: Vec<usize> = Vec::with_capacity(goals);
    let mut left: Vec<usize> = (1..=goals).collect();
    let mut at = 0usize;
    while !left.is_empty() {
        let mut best = 0usize;
        for index in 1..left.len() {
            if legs[at][left[index]] < legs[at][left[best]] {
                best = index;
            }
        }
        at = left.remove(best);
        tour.push(at);
    }
    while reverse_stretches(legs, &mut tour) || move_stretches(legs, &mut tour) {}
    tour
}

fn length(legs: &[Vec<f64>], a: usize, b: Option<&usize>) -> f64 {
    b.map_or(0.0, |&b| legs[a][b])
}

/// 2-opt on an open tour: reverses stretches that are shorter backwards.
fn reverse_stretches(legs: &[Vec<f64>], tour: &mut [usize]) -> bool {
    let mut improved = false;
    for i in 0..tour.len() {
        for j in i + 1..tour.len() {
            let before = if i == 0 { 0 } else { tour[i - 1] };
            let old = legs[before][tour[i]] + length(legs, tour[j], tour.get(j + 1));
            let new = legs[before][tour[j]] + length(legs, tour[i], tour.get(j + 1));
            if new < old - MIN_GAIN_M {
                tour[i..=j].reverse();
                improved = true;
            }
        }
    }
    improved
}

/// Or-opt: moves stretches of up to three goals to where they fit better.
fn move_stretches(legs: &[Vec<f64>], tour: &mut Vec<usize>) -> bool {
    for size in 1..=MAX_STRETCH.min(tour.len() - 1) {
        for i in 0..=tour.len() - size {
            let before = if i == 0 { 0 } else { tour[i - 1] };
            let (head, tail) = (tour[i], tour[i + size - 1]);
            let after = tour.get(i + size);
            let gain = legs[before][head] + length(legs, tail, after)
                - after.map_or(0.0, |&next| legs[before][next]);
            let rest: Vec<usize> = tour[..i].iter().chain(&tour[i + size..]).copied().collect();
            for gap in 0..=rest.len() {
                let left = if gap == 0 { 0 } else { rest[gap - 1] };
                let right = rest.get(gap);
                let cost = legs[left][head] + length(legs, tail, right) - length(legs, left, right);
                if cost < gain - MIN_GAIN_M {
                    let stretch: Vec<usize> = tour[i..i + size].to_vec();
                    *tour = rest;
                    tour.splice(gap..gap, stretch);
                    return true;
                }
            }
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// Straight distances between random stops in the unit square.
    fn legs(stops: usize, seed: u64) -> Vec<Vec<f64>> {
        let mut random = Random::new(seed);
        let at: Vec<(f64, f64)> = (0..stops)
            .map(|_| (random.uniform(), random.uniform()))
            .collect();
        let apart = |a: (f64, f64), b: (f64, f64)| (a.0 - b.0).hypot(a.1 - b.1);
        (at.iter())
            .map(|&a| at.iter().map(|&b| apart(a, b)).collect())
            .collect()
    }

    fn total(legs: &[Vec<f64>], tour: &[usize]) -> f64 {
        let mut from = 0;
        tour.iter()
            .map(|&to| legs[std::mem::replace(&mut from, to)][to])
            .sum()
    }

    /// The least length over all orders of `left`.
    fn brute_force(legs: &[Vec<f64>], at: usize, left: &[usize]) -> f64 {
        let through = |&next: &usize| {
            let rest: Vec<usize> = left.iter().copied().filter(|&g| g != next).collect();
            legs[at][next] + brute_force(legs, next, &rest)
        };
        left.iter()
            .map(through)
            .min_by(f64::total_cmp)
            .unwrap_or(0.0)
    }

    #[test]
    fn few_goals_are_visited_in_the_best_of_all_orders() {
        for seed in 0..20 {
            let legs = legs(7, seed);
            let best = brute_force(&legs, 0, &[1, 2, 3, 4, 5, 6]);
            assert!((total(&legs, &order(&legs)) - best).abs() < 1e-12);
        }
    }

    #[test]
    fn many_goals_are_all_visited_once_on_a_tour_that_no_swap_shortens() {
        let legs = legs(40, 1);
        let mut tour = order(&legs);
        assert!(total(&legs, &tour) < 6.0, "a random order takes about 20");
        assert!(
            !reverse_stretches(&legs, &mut tour.clone())
                && !move_stretches(&legs, &mut tour.clone())
        );
        tour.sort_unstable();
        assert_eq!(tour, (1..40).collect::<Vec<_>>());
    }

    #[test]
    fn lazy_ordering_gives_the_eager_order_for_fewer_legs() {
        let bounds = legs(9, 4);
        let stretched = |a: usize, b: usize| {
            bounds[a][b] * (1.0 + ((7 * a.min(b) + a.max(b)) % 5) as f64 / 10.0)
        };
        let mut asked = 0;
        let tour = lazily(bounds.clone(), |a, b| {
            asked += 1;
            stretched(a, b)
        });
        let known: Vec<Vec<f64>> = (0..9)
            .map(|a| (0..9).map(|b| stretched(a, b)).collect())
            .collect();
        assert!((total(&known, &tour) - total(&known, &order(&known))).abs() < 1e-9);
        assert!(asked < 36, "asked for {asked} of 36 legs");
    }
}
