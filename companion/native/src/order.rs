//! In which order to visit the goals: exact (Held and Karp 1962) for few, nearest neighbour with 2-opt and Or-opt for many.

const EXACT: usize = 12;

/// `legs[i][j]`: length between stops, stop 0 is the start; infinite where there is no way. Returns the goals
/// (1-based stops) in order of visit. The tour is open: it ends wherever the last goal is.
pub fn order(legs: &[Vec<f64>]) -> Vec<usize> {
    let goals = legs.len() - 1;
    if goals <= 1 {
        return (1..=goals).collect();
    }
    if goals <= EXACT {
        exact(legs)
    } else {
        heuristic(legs)
    }
}

/// Rounds of `lazily` for more goals than are ordered exactly.
const ROUNDS: usize = 40;

/// The order when the length of a leg is dear to know: unknown legs count as their lower `bounds` until a tour uses
/// them; then `evaluate` gives the true length. The result is the same as with every leg known beforehand.
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
                surprised |= length > bounds[from][to] + 1e-9;
                for (a, b) in [(from, to), (to, from)] {
                    bounds[a][b] = length;
                    known[a * stops + b] = true;
                }
            }
            from = to;
        }
        rounds += 1;
        if !surprised || (stops > EXACT + 1 && rounds >= ROUNDS) {
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
            if new < old - 1e-9 {
                tour[i..=j].reverse();
                improved = true;
            }
        }
    }
    improved
}

/// Or-opt: moves stretches of up to three goals to where they fit better.
fn move_stretches(legs: &[Vec<f64>], tour: &mut Vec<usize>) -> bool {
    for size in 1..=3usize.min(tour.len() - 1) {
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
                if cost < gain - 1e-9 {
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
