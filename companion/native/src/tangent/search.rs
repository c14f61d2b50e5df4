//! A* over tangents and arcs. A tangent is checked only when it lies on the best path so far.

use std::collections::{BinaryHeap, HashSet};

use crate::geometry::{distance, Point};
use crate::lattice::queue::Entry;
use crate::map::field::Field;
use crate::tangent::arcs::{blocked_parts, free_arc, tangent, Disc, Turn};

/// Tangents taken from the queue between two looks at the clock.
const CLOCK_PERIOD: u64 = 64;

/// The blocked parts of a rim; none when all of it is blocked.
type Rim = Option<Vec<(f64, f64)>>;

/// A tangent, and the arc before it.
#[derive(Clone, Copy)]
pub struct Step {
    /// The disc that it meets and in which sense; the goal's disc for the last one.
    pub to: (usize, Turn),
    /// Where it leaves the disc before.
    pub begin: Point,
    /// Where it meets its disc.
    pub end: Point,
    /// Radians of the rim before it.
    pub arc: f64,
    parent: usize,
    cost: f64,
}

/// A shortest path, and what the search took.
pub struct Found {
    /// The discs; the last two are the start and the goal.
    pub discs: Vec<Disc>,
    /// Tangents from the start to the goal.
    pub steps: Option<Vec<Step>>,
    /// Tangents that were looked at.
    pub iterations: u64,
}

/// The discs among which a path from `start` to `goal` that is shorter than `bound` can lead, the obstacles widened by
/// `radius`: those that meet the ellipse around both. Start and goal are the last two.
pub fn relevant_discs(
    obstacles: &[(Point, f64)],
    (start, goal): (Point, Point),
    radius: f64,
    bound: f64,
) -> Vec<Disc> {
    let widened = |&(centre, r): &(Point, f64)| Disc {
        centre,
        radius: r + radius,
    };
    let reaches = |disc: &Disc| {
        let through = distance(start, disc.centre) + distance(disc.centre, goal);
        disc.radius > 0.0 && through - 2.0 * disc.radius < bound
    };
    let ends = [start, goal].map(|centre| Disc {
        centre,
        radius: 0.0,
    });
    (obstacles.iter().map(widened).filter(reaches))
        .chain(ends)
        .collect()
}

/// The shortest path for a disc of `radius` over the rims of `discs` (see `relevant_discs`) that is shorter than `bound`;
/// none when there is none, or `late` says to give up.
pub fn search<F: Field>(
    field: &F,
    discs: Vec<Disc>,
    radius: f64,
    bound: f64,
    late: impl Fn() -> bool,
) -> Found {
    let (low, high) = field.bounds();
    let inset = (
        Point::new(low.x + radius, low.y + radius),
        Point::new(high.x - radius, high.y - radius),
    );
    let count = discs.len() - 2;
    let (start, goal) = (discs[count].centre, discs[count + 1].centre);
    let to_goal = |disc: &Disc| distance(disc.centre, goal) - disc.radius;
    let ahead: Vec<f64> = discs.iter().map(to_goal).collect();
    let mut rims: Vec<Option<Rim>> = vec![None; count];
    let mut queue: BinaryHeap<Entry> = BinaryHeap::new();
    let mut steps: Vec<Step> = vec![Step {
        to: (count, Turn::Left),
        begin: start,
        end: start,
        arc: 0.0,
        parent: usize::MAX,
        cost: 0.0,
    }];
    let mut seen: HashSet<(u32, bool, u32, bool)> = HashSet::new();
    let mut iterations = 0;
    let mut at = 0usize;
    loop {
        let Step {
            to: (number, turn),
            end,
            cost,
            ..
        } = steps[at];
        let disc = discs[number];
        let angle = disc.angle(end);
        let free = match rims.get_mut(number) {
            None => 0.0,
            Some(rim) => rim
                .get_or_insert_with(|| blocked_parts(&disc, &discs[..count], inset))
                .as_ref()
                .map_or(-1.0, |parts| free_arc(parts, turn, angle)),
        };
        for (next, onto) in discs.iter().enumerate() {
            // No path over this disc is shorter than straight lines to its rim and on to the goal.
            let least = cost + (distance(end, onto.centre) - onto.radius).max(0.0) + ahead[next];
            if next == number || next == count || least >= bound || free < 0.0 {
                continue;
            }
            for &side in if next < count {
                &Turn::BOTH[..]
            } else {
                &Turn::BOTH[..1]
            } {
                let Some((begin, meets)) = tangent((disc, turn), (*onto, side)) else {
                    continue;
                };
                let arc = if number == count {
                    0.0
                } else {
                    turn.arc(angle, disc.angle(begin))
                };
                let total = cost + arc * disc.radius + distance(begin, meets);
                let key = total + distance(meets, goal);
                if arc <= free && key < bound {
                    queue.push(Entry {
                        key,
                        index: steps.len(),
                    });
                    let to = (next, side);
                    steps.push(Step {
                        to,
                        begin,
                        end: meets,
                        arc,
                        parent: at,
                        cost: total,
                    });
                }
            }
        }
        let accepted = loop {
            let Some(Entry { index, .. }) = queue.pop() else {
                break None;
            };
            iterations += 1;
            if iterations % CLOCK_PERIOD == 0 && late() {
                break None;
            }
            let step = steps[index];
            let (from, sense) = steps[step.parent].to;
            let left = |turn: Turn| turn == Turn::Left;
            let key = (from as u32, left(sense), step.to.0 as u32, left(step.to.1));
            // The first time is the cheapest, or the tangent is blocked.
            if seen.insert(key) && field.segment_clear(step.begin, step.end, radius) {
                break Some(index);
            }
        };
        let steps = match accepted {
            Some(index) if steps[index].to.0 != count + 1 => {
                at = index;
                continue;
            }
            found => found.map(|index| traced(&steps, index)),
        };
        return Found {
            discs,
            steps,
            iterations,
        };
    }
}

/// The steps from the start to this one.
fn traced(steps: &[Step], last: usize) -> Vec<Step> {
    let mut path = Vec::new();
    let mut at = last;
    while at != 0 {
        path.push(steps[at]);
        at = steps[at].parent;
    }
    path.reverse();
    path
}
