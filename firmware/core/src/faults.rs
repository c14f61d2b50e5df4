//! What went wrong and how often: a bit and a counter for each fault of the DBC. State has room for the first sixteen.

use rover_protocol::messages::{fault_code, Fault};

/// Codes are 1 to 16; slot 0 is never used.
const CODES: usize = 17;
/// Faults that stay active until the rover is armed again.
const UNTIL_ARMED: [u8; 7] = [
    fault_code::DEAD_MAN,
    fault_code::SONAR_GUARD,
    fault_code::STALL,
    fault_code::ENCODER_LEFT,
    fault_code::ENCODER_RIGHT,
    fault_code::UNDERRUN,
    fault_code::WATCHDOG,
];
/// A fault that comes again and again is reported at most this often.
const REPORT_PERIOD_US: u64 = 100_000;

#[derive(Clone, Copy, Debug, Default)]
struct Record {
    count: u16,
    detail: u32,
    reported_us: Option<u64>,
}

#[derive(Clone, Debug, Default)]
pub struct Faults {
    active: u32,
    /// Changed since the last report.
    fresh: u32,
    records: [Record; CODES],
}

impl Faults {
    /// Something happened and is over: counted and reported, not active.
    pub fn count(&mut self, code: u8, detail: u32) {
        self.count_many(code, 1, detail);
    }

    /// As [`Faults::count`], for what happened `times` times.
    pub fn count_many(&mut self, code: u8, times: u16, detail: u32) {
        if let Some(record) = self.records.get_mut(usize::from(code)) {
            record.count = record.count.saturating_add(times);
            record.detail = detail;
            self.fresh |= bit(code);
        }
    }

    /// A fault begins; counted once for each beginning.
    pub fn raise(&mut self, code: u8, detail: u32) {
        if self.active & bit(code) == 0 {
            self.active |= bit(code);
            self.count(code, detail);
        }
    }

    /// A condition as it is now.
    pub fn set(&mut self, code: u8, active: bool, detail: u32) {
        if active {
            self.raise(code, detail);
        } else {
            self.clear(code);
        }
    }

    fn clear(&mut self, code: u8) {
        if self.active & bit(code) != 0 {
            self.active &= !bit(code);
            self.fresh |= bit(code);
        }
    }

    /// Armed anew: what ended the last drive is history.
    pub fn armed(&mut self) {
        for code in UNTIL_ARMED {
            self.clear(code);
        }
    }

    /// Bit set of active faults with a code below 16, bit number = code.
    pub fn active(&self) -> u16 {
        self.active as u16
    }

    /// The next report that is due, if any; it counts as sent.
    pub fn report(&mut self, now_us: u64) -> Option<Fault> {
        if self.fresh == 0 {
            return None;
        }
        let (active, fresh) = (self.active, self.fresh);
        let (code, record) = self.records.iter_mut().enumerate().find(|(code, record)| {
            let waits = record
                .reported_us
                .is_some_and(|at| now_us.saturating_sub(at) < REPORT_PERIOD_US);
            fresh & bit(*code as u8) != 0 && !waits
        })?;
        let code = code as u8;
        self.fresh &= !bit(code);
        record.reported_us = Some(now_us);
        Some(Fault {
            code,
            active: u8::from(active & bit(code) != 0),
            count: record.count,
            detail: record.detail,
        })
    }
}

fn bit(code: u8) -> u32 {
    1_u32.checked_shl(u32::from(code)).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fault_that_lasts_is_counted_once_and_reported_at_its_begin_and_end() {
        let mut faults = Faults::default();
        faults.set(fault_code::LOW_BATTERY, true, 6_100);
        faults.set(fault_code::LOW_BATTERY, true, 6_000);
        let report = faults.report(0).unwrap();
        assert_eq!((report.code, report.active), (fault_code::LOW_BATTERY, 1));
        assert_eq!((report.count, report.detail), (1, 6_100));
        assert_eq!(faults.report(1), None);
        faults.set(fault_code::LOW_BATTERY, false, 0);
        assert_eq!(faults.report(50_000), None, "at most ten a second");
        assert_eq!(faults.report(100_000).unwrap().active, 0);
    }

    #[test]
    fn a_thousand_events_make_one_report_and_a_counter() {
        let mut faults = Faults::default();
        for i in 0..1_000 {
            faults.count(fault_code::SEGMENT_REJECTED, i);
        }
        assert_eq!(faults.report(0).unwrap().count, 1_000);
        assert_eq!(faults.report(0), None);
        assert_eq!(faults.active(), 0);
    }

    #[test]
    fn arming_clears_what_ended_the_last_drive_and_nothing_else() {
        let mut faults = Faults::default();
        faults.raise(fault_code::DEAD_MAN, 0);
        faults.raise(fault_code::SONAR_DEAD, 2);
        assert_eq!(faults.active(), 0b1000_0010);
        faults.armed();
        assert_eq!(faults.active(), 0b1000_0000);
        faults.count(200, 0);
    }
}
