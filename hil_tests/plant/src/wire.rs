//! Baud timing from the host to the firmware: bytes written at one moment arrive one after the other, and each
//! millisecond carries whole bytes, as an adapter on USB hands them over.

/// Ten bit times carry a byte (start, eight data, stop).
const BITS_PER_BYTE: u64 = 10;
const MICROSECONDS: u64 = 1_000_000;

pub struct Wire {
    baud: u64,
    written: u64,
    arrived: u64,
    /// Bit time saved up towards the next byte, in bits × 1e6.
    credit: u64,
}

impl Wire {
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
