//! Shortest paths over a lattice: A* to one goal, Dijkstra's search to several at once.

use std::collections::BTreeMap;

use crate::geometry::Point;
use crate::lattice::frontier::{octile, Frontier};
use crate::lattice::graph::Lattice;
use crate::map::field::Field;

/// Columns and rows from the start's and the goals' cells to those that they are linked to.
const LINK_REACH: i64 = 2;
/// Cells expanded between two looks at the clock.
const CLOCK_PERIOD: usize = 1024;

/// What a search found, and what it took.
pub struct Found {
    /// Per goal the path from the start, both ends included; none where the lattice has none.
    pub paths: Vec<Option<Vec<Point>>>,
    /// Cells that were expanded.
    pub expanded: u64,
    /// Cells that were labelled.
    pub labelled: usize,
}

/// The path from `start` to each goal, with exact edges; none where the lattice has none. `late` is asked now and then
/// whether to give up.
pub fn search<F: Field>(
    lattice: &mut Lattice,
    field: &F,
    start: Point,
    goals: &[Point],
    late: impl Fn() -> bool,
) -> Found {
    let (towards, least) = match goals {
        [goal] => (Some(*goal), octile(start, *goal)),
        _ => (None, 0.0),
    };
    let mut frontier = Frontier::new(lattice, towards, least);
    for (index, length) in lattice.links(field, start, LINK_REACH) {
        frontier.add_source(lattice, index, length);
    }
    let mut ends: BTreeMap<usize, Vec<(usize, f64)>> = BTreeMap::new();
    for (goal, &p) in goals.iter().enumerate() {
        for (index, length) in lattice.links(field, p, LINK_REACH) {
            ends.entry(index).or_default().push((goal, length));
            frontier.mark_target(index);
        }
    }
    let mut best = vec![(f64::INFINITY, usize::MAX); goals.len()];
    let mut farthest = f64::INFINITY;
    let mut expanded = 0usize;
    while let Some((cost, index)) = frontier.pop() {
        if frontier.lower_bound() >= farthest {
            break;
        }
        expanded += 1;
        if expanded.is_multiple_of(CLOCK_PERIOD) && late() {
            best.fill((f64::INFINITY, usize::MAX));
            break;
        }
        if frontier.is_target(index) {
            for &(goal, length) in &ends[&index] {
                if cost + length < best[goal].0 {
                    best[goal] = (cost + length, index);
                }
            }
            farthest = best.iter().fold(0.0, |most, &(length, _)| most.max(length));
        }
        frontier.expand(lattice, field, cost, index);
    }
    let path = |end: usize, goal: Point| {
        let inner = corners(lattice, frontier.path_to(lattice, end));
        [start].into_iter().chain(inner).chain([goal]).collect()
    };
    let found = best
        .iter()
        .zip(goals)
        .map(|(&(_, end), &goal)| (end != usize::MAX).then(|| path(end, goal)))
        .collect();
    let (expanded, labelled) = (frontier.expanded(), frontier.labelled());
    frontier.release(lattice);
    Found {
        paths: found,
        expanded,
        labelled,
    }
}

/// The ends of a path over cells, and where it turns.
pub fn corners(lattice: &Lattice, cells: Vec<usize>) -> Vec<Point> {
    let step = |index: usize| cells[index + 1] as i64 - cells[index] as i64;
    let last = cells.len() - 1;
    (0..=last)
        .filter(|&index| index == 0 || index == last || step(index) != step(index - 1))
        .map(|index| lattice.point(cells[index]))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::path_length;
    use crate::map::grid::Grid;

    /// 10 × 10 m in cells of 1 m with a wall from the left that leaves the last column open.
    fn walled() -> Grid {
        let mut blocked = vec![0u8; 100];
        blocked[50..59].fill(1);
        Grid::new(blocked, 10, 10, 1.0, Point::new(0.0, 0.0))
    }

    #[test]
    fn the_path_leads_around_the_wall_and_is_the_shortest_on_the_lattice() {
        let field = walled();
        let mut lattice = Lattice::new(&field, 1.0, 0.2);
        let (start, goal) = (Point::new(0.5, 4.5), Point::new(0.5, 6.5));
        let found = search(&mut lattice, &field, start, &[goal], || false);
        let path = found.paths[0].as_ref().expect("there is a way around");
        // Nine columns out and back, and two rows up past the end of the wall.
        let shortest = 20.0;
        assert!(
            path_length(path) <= shortest + 1e-9,
            "{}",
            path_length(path)
        );
        assert!(path
            .windows(2)
            .all(|edge| field.segment_clear(edge[0], edge[1], 0.2)));
    }

    #[test]
    fn one_search_answers_for_several_goals_and_says_none_for_a_blocked_one() {
        let field = walled();
        let mut lattice = Lattice::new(&field, 1.0, 0.2);
        let goals = [
            Point::new(9.5, 0.5),
            Point::new(3.5, 5.5),
            Point::new(0.5, 9.5),
        ];
        let found = search(&mut lattice, &field, Point::new(0.5, 0.5), &goals, || false);
        assert_eq!(
            found.paths.iter().map(Option::is_some).collect::<Vec<_>>(),
            [true, false, true]
        );
    }

    #[test]
    fn a_search_that_is_out_of_time_finds_nothing() {
        let field = Grid::new(vec![0; 90_000], 300, 300, 1.0, Point::new(0.0, 0.0));
        let mut lattice = Lattice::new(&field, 1.0, 0.2);
        let goals = [Point::new(299.5, 299.5), Point::new(299.5, 0.5)];
        let found = search(&mut lattice, &field, Point::new(0.5, 0.5), &goals, || true);
        assert!(found.paths.iter().all(Option::is_none));
    }
}
