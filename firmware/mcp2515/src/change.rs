//! What has gone wrong between two looks at the statistics.

use crate::{BusState, Statistics};

/// Differences of the counters of faults, and the change of the bus state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Change {
    /// See [`Statistics::overflows`].
    pub overflows: u16,
    /// See [`Statistics::message_errors`].
    pub message_errors: u16,
    /// See [`Statistics::passive`].
    pub passive: u16,
    /// See [`Statistics::bus_off`].
    pub bus_off: u16,
    /// See [`Statistics::abandoned`].
    pub abandoned: u16,
    /// See [`Statistics::lost_chip`].
    pub lost_chip: u16,
    /// Off the bus before, and on it now.
    pub recovered: bool,
}

impl Statistics {
    /// What came since `earlier`.
    pub fn since(&self, earlier: &Self) -> Change {
        Change {
            overflows: self.overflows.wrapping_sub(earlier.overflows),
            message_errors: self.message_errors.wrapping_sub(earlier.message_errors),
            passive: self.passive.wrapping_sub(earlier.passive),
            bus_off: self.bus_off.wrapping_sub(earlier.bus_off),
            abandoned: self.abandoned.wrapping_sub(earlier.abandoned),
            lost_chip: self.lost_chip.wrapping_sub(earlier.lost_chip),
            recovered: earlier.state == BusState::Off && self.state != BusState::Off,
        }
    }

    /// State and error counters in one number: 2^24 × state (1 active, 2 warning, 3 passive, 4 off), 256 × transmit
    /// counter, receive counter. Never 0.
    pub fn summary(&self) -> u32 {
        let state = match self.state {
            BusState::Active => 1,
            BusState::Warning => 2,
            BusState::Passive => 3,
            BusState::Off => 4,
        };
        u32::from_be_bytes([state, 0, self.transmit_errors, self.receive_errors])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_came_since_counts_also_across_a_wrap() {
        let earlier = Statistics {
            overflows: 65_535,
            bus_off: 3,
            state: BusState::Off,
            ..Statistics::default()
        };
        let now = Statistics {
            overflows: 1,
            state: BusState::Warning,
            ..earlier
        };
        let change = Change {
            overflows: 2,
            recovered: true,
            ..Change::default()
        };
        assert_eq!(now.since(&earlier), change);
        assert_eq!(now.since(&now), Change::default());
    }

    #[test]
    fn the_summary_shows_state_and_counters() {
        let statistics = Statistics {
            transmit_errors: 130,
            receive_errors: 7,
            state: BusState::Passive,
            ..Statistics::default()
        };
        assert_eq!(statistics.summary(), 0x0300_8207);
        assert_eq!(Statistics::default().summary(), 0x0100_0000);
    }
}
