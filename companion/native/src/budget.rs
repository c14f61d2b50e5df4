//! How long a search may go on: counted iterations (repeatable) or a deadline (not repeatable).

use std::time::{Duration, Instant};

/// What a lattice's cell costs the searches of one tour, about, before any has been timed.
const SECONDS_PER_CELL: f64 = 50e-9;
/// Cells above which a lattice costs more than it brings to a counted budget.
const COUNTED_CELLS: f64 = 60_000.0;

/// How fast lattices have been searched so far.
#[derive(Default)]
pub struct Pace {
    seconds_per_cell: Option<f64>,
}

impl Pace {
    pub fn expected(&self, cells: f64) -> f64 {
        cells * self.seconds_per_cell.unwrap_or(SECONDS_PER_CELL)
    }

    pub fn saw(&mut self, cells: f64, seconds: f64) {
        self.seconds_per_cell = Some(seconds / cells);
    }
}

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

    /// From now on time ends so many `milliseconds` after `started`, if that is said.
    pub fn end_after(&mut self, started: Instant, milliseconds: Option<f64>) {
        self.deadline =
            milliseconds.map(|ms| started + Duration::from_secs_f64(ms.clamp(0.0, 1e9) * 1e-3));
        self.expired = self.late();
    }

    /// A new total of iterations for what follows.
    pub fn improve_until(&mut self, limit: u64) {
        self.limit = limit;
        self.expired = self.late();
    }

    /// Counts one iteration; false when none is left. The clock is only read every 8 iterations.
    pub fn spend(&mut self) -> bool {
        if self.expired || self.used >= self.limit {
            return false;
        }
        self.used += 1;
        if self.used.is_multiple_of(8) {
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

    /// True when there is time for searches over a lattice of so many `cells` that take `seconds`, about. Counted
    /// budgets get a fixed answer, so that they stay repeatable.
    pub fn affords(&self, seconds: f64, cells: f64) -> bool {
        if self.expired || self.used >= self.limit {
            return false;
        }
        match self.deadline {
            None => cells <= COUNTED_CELLS,
            Some(deadline) => {
                let left = deadline.saturating_duration_since(Instant::now());
                seconds < 0.8 * left.as_secs_f64()
            }
        }
    }

    pub fn deadline(&self) -> Option<Instant> {
        self.deadline
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
