//! How long a search may go on: counted iterations (repeatable) or a deadline (not repeatable).

use std::time::{Duration, Instant};

/// Iterations between two looks at the clock.
const CLOCK_PERIOD: u64 = 8;
/// The longest budget, in milliseconds: eleven days.
const MAX_BUDGET_MS: f64 = 1e9;

/// Iterations and time that are left.
pub struct Budget {
    /// Iterations so far.
    pub used: u64,
    limit: u64,
    deadline: Option<Instant>,
    expired: bool,
}

impl Budget {
    /// So many iterations and no end of time.
    pub fn new(limit: u64) -> Self {
        Self {
            used: 0,
            limit,
            deadline: None,
            expired: false,
        }
    }

    /// From now on, time ends so many `milliseconds` after `started` and there are so many `iterations`, where these are
    /// given.
    pub fn begin_improvement(
        &mut self,
        started: Instant,
        milliseconds: Option<f64>,
        iterations: Option<u64>,
    ) {
        let duration = |ms: f64| Duration::from_secs_f64(ms.clamp(0.0, MAX_BUDGET_MS) * 1e-3);
        self.deadline = milliseconds.map(|ms| started + duration(ms));
        self.limit = iterations.map_or(u64::MAX, |limit| self.used.saturating_add(limit));
        self.expired = self.late();
    }

    /// Counts one iteration; false when none is left. The clock is only read now and then.
    pub fn spend(&mut self) -> bool {
        if self.expired || self.used >= self.limit {
            return false;
        }
        self.used += 1;
        if self.used.is_multiple_of(CLOCK_PERIOD) {
            self.expired = self.late();
        }
        true
    }

    /// True when no iteration is left.
    pub fn exhausted(&self) -> bool {
        self.expired || self.used >= self.limit
    }

    /// True when the time is over, by the clock.
    pub fn late(&self) -> bool {
        self.deadline
            .is_some_and(|deadline| Instant::now() >= deadline)
    }

    /// When the time is over, if ever.
    pub fn deadline(&self) -> Option<Instant> {
        self.deadline
    }

    /// Lets a nested search use at most `share` iterations more; returns what `restore` needs.
    pub fn capped(&mut self, share: u64) -> u64 {
        let whole = self.limit;
        self.limit = whole.min(self.used.saturating_add(share));
        whole
    }

    /// Ends the cap on a nested search.
    pub fn restore(&mut self, whole: u64) {
        self.limit = whole;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn iterations_are_counted_to_the_limit_and_not_beyond() {
        let mut budget = Budget::new(3);
        assert_eq!((0..5).filter(|_| budget.spend()).count(), 3);
        assert!(budget.exhausted() && !budget.late());
        budget.begin_improvement(Instant::now(), None, Some(1));
        assert!(budget.spend() && !budget.spend());
        assert_eq!(budget.used, 4);
    }

    #[test]
    fn a_capped_search_leaves_the_rest_to_others() {
        let mut budget = Budget::new(10);
        let whole = budget.capped(4);
        assert_eq!((0..10).filter(|_| budget.spend()).count(), 4);
        budget.restore(whole);
        assert_eq!((0..10).filter(|_| budget.spend()).count(), 6);
    }

    #[test]
    fn a_deadline_in_the_past_ends_everything_at_once() {
        let mut budget = Budget::new(1_000);
        budget.begin_improvement(Instant::now(), Some(0.0), None);
        assert!(budget.late() && budget.exhausted() && !budget.spend());
    }
}
