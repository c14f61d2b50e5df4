//! Entries of a priority queue that gives the smallest key first and is the same on every run.

use std::cmp::Ordering;

/// Heap entry: the smallest key first, of equals the lower index.
pub struct Entry {
    /// What entries are ordered by.
    pub key: f64,
    /// What waits: a node, a cell, an edge.
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BinaryHeap;

    #[test]
    fn the_smallest_key_comes_first_and_of_equals_the_lowest_index() {
        let entries = [(2.0, 1), (1.0, 7), (1.0, 3)].map(|(key, index)| Entry { key, index });
        let mut heap = BinaryHeap::from(entries);
        let order: Vec<usize> =
            std::iter::from_fn(|| heap.pop().map(|entry| entry.index)).collect();
        assert_eq!(order, [3, 7, 1]);
    }
}
