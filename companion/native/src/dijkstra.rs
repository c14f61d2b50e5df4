//! Travel distance from one cell to every other over free cells.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use crate::lattice::NEIGHBOURS;

/// Heap entry: the smallest key first, of equals the lower index.
pub struct Entry {
    pub key: f64,
    pub index: usize,
}

impl PartialEq for Entry {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Entry {}
impl PartialOrd for Entry {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Entry {
    fn cmp(&self, other: &Self) -> Ordering {
        other
            .key
            .total_cmp(&self.key)
            .then_with(|| other.index.cmp(&self.index))
    }
}

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
