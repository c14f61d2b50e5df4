//! The serial wire: bytes both ways, what is sent metered by the baud rate.

use std::os::fd::AsFd;

use rover_core::Core;

use crate::line::Line;

/// Ten bit times carry a byte.
const BITS_PER_BYTE: u64 = 10;

pub struct Serial {
    line: Line,
    meter: Meter,
}

impl Serial {
    pub fn new(line: Line, baud: u32) -> Self {
        Self {
            line,
            meter: Meter::new(baud),
        }
    }

    pub fn bytes_sent(&self) -> u64 {
        self.line.bytes_sent()
    }

    /// Feed the core what the host has sent; see [`Line::receive`].
    pub fn receive(&mut self, core: &mut Core, due: u64, now_us: u64, ticks: &impl AsFd) -> bool {
        self.line
            .receive(due, ticks, |bytes| core.receive(bytes, now_us))
    }

    /// Send what the core has to say, as much as the baud rate lets through until `now_us`.
    pub fn transmit(&mut self, core: &mut Core, now_us: u64) {
        let mut buffer = [0; 4096];
        let room = buffer.len().min(self.line.room());
        let count = self.meter.take(core, now_us, &mut buffer[..room]);
        self.line.send(&buffer[..count]);
    }
}

/// Lets as many bytes out of the core as a UART sends in the time that has passed.
pub struct Meter {
    baud: u64,
    last_us: u64,
    /// Bit time saved up towards the next byte, in bits times 1e6.
    credit: u64,
}

impl Meter {
    pub fn new(baud: u32) -> Self {
        Self {
            baud: u64::from(baud),
            last_us: 0,
            credit: 0,
        }
    }

    /// Fill `out` as far as time and the core go; returns how many bytes that are.
    pub fn take(&mut self, core: &mut Core, now_us: u64, out: &mut [u8]) -> usize {
        let elapsed_us = now_us.saturating_sub(self.last_us).min(100_000);
        self.last_us = now_us;
        self.credit += elapsed_us * self.baud;
        let allowed = self.credit / (BITS_PER_BYTE * 1_000_000);
        let room = (allowed as usize).min(out.len());
        let count = core.transmit(&mut out[..room]);
        if count < room {
            // An idle wire saves no time up for later.
            self.credit = 0;
        } else {
            self.credit -= allowed * BITS_PER_BYTE * 1_000_000;
        }
        count
    }
}
