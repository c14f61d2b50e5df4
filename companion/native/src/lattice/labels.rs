//! What a search writes on cells.

/// Not reached.
pub const UNREACHED: u8 = 0;
/// Reached from a source itself.
pub const SOURCE: u8 = 1;
/// Reached by a step in the first of the directions of `NEIGHBOURS`; the others follow.
pub const FIRST_DIRECTION: u8 = 2;
/// Set beside these where the search may end.
pub const TARGET: u8 = 0x80;

/// Costs and parents of cells, and the queue. Wiped after each search, so that the next one does not pay for a whole map.
#[derive(Default)]
pub struct Labels {
    pub(super) cost: Vec<f32>,
    pub(super) state: Vec<u8>,
    touched: Vec<u32>,
    /// Per bucket of the queue the entry that was put in last.
    heads: Vec<u32>,
    entries: Vec<Entry>,
}

/// A cell that waits to be expanded.
#[derive(Clone, Copy)]
struct Entry {
    cell: u32,
    /// Its cost when it was put in.
    cost: f32,
    /// The entry of the same bucket that was put in before it.
    next: u32,
}

/// No entry.
const NONE: u32 = u32::MAX;

impl Labels {
    /// Blank labels for so many `cells`.
    pub fn new(cells: usize) -> Self {
        // Zeroed pages cost nothing until they are touched: of a large map mostly few are.
        Self {
            cost: vec![0.0; cells],
            state: vec![UNREACHED; cells],
            touched: Vec::new(),
            heads: Vec::new(),
            entries: Vec::new(),
        }
    }

    pub(super) fn set(&mut self, index: usize, cost: f32, state: u8) {
        if self.state[index] == UNREACHED {
            self.touched.push(index as u32);
        }
        self.cost[index] = cost;
        self.state[index] = state;
    }

    /// True when the search has reached this cell.
    pub fn reached(&self, index: usize) -> bool {
        self.state[index] & !TARGET != UNREACHED
    }

    /// How many cells the search has labelled.
    pub fn count(&self) -> usize {
        self.touched.len()
    }

    /// Makes all labels blank again.
    pub fn wipe(&mut self) {
        for index in self.touched.drain(..) {
            self.state[index as usize] = UNREACHED;
        }
        self.heads.clear();
        self.entries.clear();
    }

    /// Puts a cell into a bucket of the queue.
    pub(super) fn push(&mut self, bucket: usize, cell: usize, cost: f32) {
        if bucket >= self.heads.len() {
            self.heads.resize(bucket + 1, NONE);
        }
        let next = std::mem::replace(&mut self.heads[bucket], self.entries.len() as u32);
        let cell = cell as u32;
        self.entries.push(Entry { cell, cost, next });
    }

    /// Takes the cell that was put into this bucket last, with its cost then.
    pub(super) fn pop(&mut self, bucket: usize) -> Option<(f32, usize)> {
        let head = self.heads.get_mut(bucket)?;
        let entry = self.entries.get(*head as usize)?;
        *head = entry.next;
        Some((entry.cost, entry.cell as usize))
    }

    /// Number of buckets.
    pub(super) fn buckets(&self) -> usize {
        self.heads.len()
    }
}
