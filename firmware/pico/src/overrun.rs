//! A mark that a receiver has lost something, for the core to count.

use core::sync::atomic::{AtomicBool, Ordering};

pub struct Overrun(AtomicBool);

impl Overrun {
    pub const fn new() -> Self {
        Self(AtomicBool::new(false))
    }

    pub fn note(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether that has happened since the last call. What comes between the two steps is told by this call.
    pub fn take(&self) -> bool {
        let lost = self.0.load(Ordering::Relaxed);
        if lost {
            self.0.store(false, Ordering::Relaxed);
        }
        lost
    }
}
