//! Baud timing from the host to the firmware: bytes written at one moment arrive one after the other, and each
//! millisecond carries whole bytes, as an adapter on USB hands them over.

/// Ten bit times carry a byte (start, eight data, stop).
const BITS_PER_BYTE: u64 = 10;
const MICROSECONDS: u64 = 1_000_000;

/// Bytes on their way from the host to the firmware.
pub struct Wire {
    baud: u64,
    written: u64,
    arrived: u64,
    /// Bit time saved up towards the next byte, in bits × 1e6.
    credit: u64,
}

impl Wire {
    /// An idle line of `baud` bits per second.
    pub fn new(baud: u64) -> Self {
        Self {
            baud,
            written: 0,
            arrived: 0,
            credit: 0,
        }
    }

    /// The host's total so far; a smaller total than before changes nothing.
    pub fn write(&mut self, total: u64) {
        self.written = self.written.max(total);
    }

    /// Everything written up to `total` is gone, on the wire or not.
    pub fn drop_until(&mut self, total: u64) {
        self.written = total;
        self.arrived = total;
        self.credit = 0;
    }

    /// Bytes that have arrived after `elapsed_us` more.
    pub fn pass(&mut self, elapsed_us: u64) -> u64 {
        if self.arrived == self.written {
            self.credit = 0;
            return self.arrived;
        }
        const BYTE: u64 = BITS_PER_BYTE * MICROSECONDS;
        let elapsed = elapsed_us * self.baud;
        self.credit += elapsed;
        let whole = (self.credit / BYTE).min((elapsed / BYTE).max(1));
        let bytes = whole.min(self.written - self.arrived);
        self.credit = (self.credit - bytes * BYTE).min(BYTE);
        self.arrived += bytes;
        self.arrived
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::Config;

    #[test]
    fn bytes_come_at_the_baud_rate_and_none_is_lost() {
        let mut wire = Wire::new(Config::default().baud);
        wire.write(1000);
        let arrived: Vec<u64> = (0..50).map(|_| wire.pass(1000)).collect();
        // 23.04 bytes a millisecond.
        assert_eq!(arrived[0], 23);
        assert!(arrived.windows(2).all(|pair| pair[1] - pair[0] <= 24));
        assert_eq!(arrived.iter().position(|total| *total == 1000), Some(43));
    }

    #[test]
    fn an_idle_line_saves_nothing_up() {
        let mut wire = Wire::new(Config::default().baud);
        for _ in 0..100 {
            assert_eq!(wire.pass(1000), 0);
        }
        wire.write(500);
        assert_eq!(wire.pass(1000), 23);
    }

    #[test]
    fn a_slow_line_still_gets_its_bytes_through() {
        let mut wire = Wire::new(1200);
        wire.write(3);
        let first = (1..).find(|_| wire.pass(1000) == 1);
        assert_eq!(first, Some(9), "8.33 ms a byte");
    }

    #[test]
    fn what_was_on_the_line_at_a_restart_is_gone() {
        let mut wire = Wire::new(Config::default().baud);
        wire.write(100);
        wire.pass(1000);
        wire.drop_until(100);
        assert_eq!(wire.pass(1000), 100);
        wire.write(90);
        assert_eq!(wire.pass(1000), 100, "a smaller total changes nothing");
    }
}
