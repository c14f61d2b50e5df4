//! Squares of ground and rows of cells, as a grid's collision check needs them.

use crate::geometry::{point_segment_squared, Point};

/// Cells that two words hold: a shorter row is looked at without a loop.
pub const MAX_WORDS_CELLS: usize = 16;

/// True when none of the cells is blocked; eight at a time.
pub fn all_free(line: &[u8]) -> bool {
    let word = |bytes: &[u8; 8]| u64::from_ne_bytes(*bytes);
    if let (Some(first), Some(last)) = (line.first_chunk(), line.last_chunk()) {
        // Up to 16 cells are two words that may overlap.
        let between =
            line.len() > MAX_WORDS_CELLS && line[8..line.len() - 8].iter().any(|&cell| cell != 0);
        return word(first) | word(last) == 0 && !between;
    }
    line.iter().all(|&cell| cell == 0)
}

/// Squared distance between the box from `low` to `high` and the segment `a`–`b`.
pub fn distance_squared(low: Point, high: Point, a: Point, b: Point) -> f64 {
    if crosses(a, b, low, high) {
        return 0.0;
    }
    let to_box = |p: Point| {
        let dx = (low.x - p.x).max(p.x - high.x).max(0.0);
        let dy = (low.y - p.y).max(p.y - high.y).max(0.0);
        dx * dx + dy * dy
    };
    [
        low,
        Point::new(high.x, low.y),
        high,
        Point::new(low.x, high.y),
    ]
    .iter()
    .map(|&corner| point_segment_squared(corner, a, b))
    .fold(to_box(a).min(to_box(b)), f64::min)
}

/// True when the segment meets the open box (slab test).
fn crosses(a: Point, b: Point, low: Point, high: Point) -> bool {
    let (mut enter, mut leave) = (0.0f64, 1.0f64);
    for (from, to, least, most) in [(a.x, b.x, low.x, high.x), (a.y, b.y, low.y, high.y)] {
        let step = to - from;
        if step == 0.0 {
            if from <= least || from >= most {
                return false;
            }
        } else {
            let (first, second) = ((least - from) / step, (most - from) / step);
            enter = enter.max(first.min(second));
            leave = leave.min(first.max(second));
        }
    }
    enter < leave
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_blocked_cell_anywhere_in_a_row_of_any_length_is_seen() {
        for length in 0..40 {
            assert!(all_free(&vec![0; length]));
            for blocked in 0..length {
                let mut line = vec![0u8; length];
                line[blocked] = 1;
                assert!(!all_free(&line), "cell {blocked} of {length}");
            }
        }
    }

    #[test]
    fn the_distance_to_a_box_is_that_to_its_side_its_corner_or_none_inside() {
        let (low, high) = (Point::new(0.0, 0.0), Point::new(1.0, 1.0));
        let apart =
            |ax, ay, bx, by| distance_squared(low, high, Point::new(ax, ay), Point::new(bx, by));
        assert_eq!(apart(-1.0, 0.5, 2.0, 0.5), 0.0);
        assert_eq!(apart(-1.0, 3.0, 2.0, 3.0), 4.0);
        assert_eq!(apart(4.0, 5.0, 8.0, 9.0), 25.0);
        // Past the corner (1, 1): the nearest point is inside the segment, not at its ends.
        assert!((apart(1.0, 2.0, 2.0, 1.0) - 0.5).abs() < 1e-12);
    }
}
