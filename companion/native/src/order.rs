//! In which order to visit the goals: exact (Held and Karp 1962) for few, nearest neighbour with 2-opt for many.

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
    let leg = |a: usize, b: Option<&usize>| b.map_or(0.0, |&b| legs[a][b]);
    let mut improved = true;
    while improved {
        improved = false;
        for i in 0..goals {
            for j in i + 1..goals {
                let before = if i == 0 { 0 } else { tour[i - 1] };
                let old = legs[before][tour[i]] + leg(tour[j], tour.get(j + 1));
                let new = legs[before][tour[j]] + leg(tour[i], tour.get(j + 1));
                if new < old - 1e-9 {
                    tour[i..=j].reverse();
                    improved = true;
                }
            }
        }
    }
    tour
}
