//! How long a search may go on: counted iterations (repeatable) or a deadline (not repeatable).

use std::time::{Duration, Instant};

/// What a lattice's cell costs a search, about.
const SECONDS_PER_CELL: f64 = 20e-9;
/// Cells above which a lattice costs more than it brings to a counted budget.
const COUNTED_CELLS: usize = 60_000;

pub struct Budget {
    pub used: u64,
    limit: u64,
    deadline: Option<Instant>,
    expired: bool,
}

impl Budget {
    pub fn new(limit: u64) -> Self {
        Self {
            used: 0,
            limit,
            deadline: None,
            expired: false,
        }
    }

    /// New limits for what follows: a total of iterations, a time since `started`.
    pub fn improve_until(&mut self, limit: u64, started: Instant, milliseconds: Option<f64>) {
        self.limit = limit;
        self.deadline =
            milliseconds.map(|ms| started + Duration::from_secs_f64(ms.clamp(0.0, 1e9) * 1e-3));
        self.expired = self.late();
    }

    /// Counts one iteration; false when none is left. The clock is only read every 32 iterations.
    pub fn spend(&mut self) -> bool {
        if self.expired || self.used >= self.limit {
            return false;
        }
        self.used += 1;
        if self.used.is_multiple_of(32) {
            self.expired = self.late();
        }
        true
    }

    pub fn exhausted(&self) -> bool {
        self.expired || self.used >= self.limit
    }

    pub fn late(&self) -> bool {
        self.deadline
            .is_some_and(|deadline| Instant::now() >= deadline)
    }

    /// How many cells a lattice may have so that `searches` over it leave time for other things; none when nothing
    /// is to be improved. Counted budgets get a fixed answer, so that they stay repeatable.
    pub fn lattice_cells(&self, searches: usize) -> Option<usize> {
        if self.expired || self.used >= self.limit {
            return None;
        }
        Some(match self.deadline {
            None => COUNTED_CELLS,
            Some(deadline) => {
                let left = deadline.saturating_duration_since(Instant::now());
                let share = 0.5 * left.as_secs_f64() / searches.max(1) as f64;
                (share / SECONDS_PER_CELL) as usize
            }
        })
    }

    /// Lets a nested search use at most `share` iterations more.
    pub fn capped(&mut self, share: u64) -> u64 {
        let whole = self.limit;
        self.limit = whole.min(self.used.saturating_add(share));
        whole
    }

    pub fn restore(&mut self, whole: u64) {
        self.limit = whole;
    }
}
