//! Travel distance from one cell to every other over free cells.

use std::collections::BinaryHeap;

use crate::lattice::graph::NEIGHBOURS;
use crate::lattice::queue::Entry;

/// Metres to each cell, row-major; infinite where there is no way. Diagonal steps need both cells beside them free.
pub fn distances(
    blocked: &[u8],
    columns: usize,
    rows: usize,
    start: usize,
    resolution: f64,
) -> Vec<f32> {
    let mut cost = vec![f64::INFINITY; columns * rows];
    let mut heap = BinaryHeap::new();
    cost[start] = 0.0;
    heap.push(Entry {
        key: 0.0,
        index: start,
    });
    while let Some(Entry { key, index }) = heap.pop() {
        if key > cost[index] {
            continue;
        }
        let (x, y) = ((index % columns) as i64, (index / columns) as i64);
        let free = |x: i64, y: i64| {
            x >= 0
                && y >= 0
                && x < columns as i64
                && y < rows as i64
                && blocked[y as usize * columns + x as usize] == 0
        };
        for (dx, dy) in NEIGHBOURS {
            let diagonal = dx != 0 && dy != 0;
            if !free(x + dx, y + dy) || (diagonal && !(free(x + dx, y) && free(x, y + dy))) {
                continue;
            }
            let next = (y + dy) as usize * columns + (x + dx) as usize;
            let step = if diagonal {
                std::f64::consts::SQRT_2
            } else {
                1.0
            };
            let new = key + step * resolution;
            if new < cost[next] {
                cost[next] = new;
                heap.push(Entry {
                    key: new,
                    index: next,
                });
            }
        }
    }
    cost.iter().map(|&c| c as f32).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn travel_goes_around_a_wall_and_cuts_no_corner() {
        #[rustfmt::skip]
        let blocked = [
            0, 0, 0,
            0, 1, 0,
            0, 1, 0,
        ];
        let metres = distances(&blocked, 3, 3, 6, 0.5);
        // Two cells up, two across, two down: the corners of the wall allow no diagonal.
        assert_eq!(metres[8], 3.0);
        assert_eq!(metres[4], f32::INFINITY);
    }

    #[test]
    fn a_diagonal_over_free_ground_costs_the_square_root_of_two() {
        let metres = distances(&[0; 9], 3, 3, 0, 1.0);
        assert!((metres[8] - 2.0 * std::f32::consts::SQRT_2).abs() < 1e-6);
    }
}
