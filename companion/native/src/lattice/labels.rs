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
    pub(super) cost: Vec<f64>,
    pub(super) state: Vec<u8>,
    touched: Vec<u32>,
    /// Cells that wait to be expanded, with their cost when they were put in.
    pub(super) buckets: Vec<Vec<(f64, u32)>>,
}

impl Labels {
    /// Blank labels for so many `cells`.
    pub fn new(cells: usize) -> Self {
        // Zeroed pages cost nothing until they are touched: of a large map mostly few are.
        Self {
            cost: vec![0.0; cells],
            state: vec![UNREACHED; cells],
            touched: Vec::new(),
            buckets: Vec::new(),
        }
    }

    pub(super) fn set(&mut self, index: usize, cost: f64, state: u8) {
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
        for bucket in &mut self.buckets {
            bucket.clear();
        }
    }
}
