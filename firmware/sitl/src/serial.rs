//! The serial wire: bytes both ways with the times that the board's UART gives them.
//!
//! The board's driver is told of bytes when 16 are waiting or the line has been silent for 32 bits, and the core takes
//! them in the tick after that; it sends in each tick what the line takes until the next. The emulated board does so
//! by itself (`hil_tests/rover_hil/emulator`): the same bytes reach the same tick here.

use std::collections::VecDeque;
use std::os::fd::AsFd;

use rover_core::Core;

use crate::line::Line;

/// Ten bit times carry a byte.
const BITS_PER_BYTE: u64 = 10;
const NANOSECONDS: u64 = 1_000_000_000;
const TICK_NS: u64 = 1_000_000;
/// A request tells of the millisecond that ends with its tick; what came in it is on the pins this much later.
const WORLD_BEHIND_NS: u64 = 806_000;
/// Receive interrupt at so many bytes, and after so many bits of silence.
const HALF_FULL: usize = 16;
const SILENCE_BITS: u64 = 32;
/// Until the driver has read the time.
const SERVICE_NS: u64 = 1_000;

pub struct Serial {
    line: Line,
    receiver: Receiver,
    meter: Meter,
    /// On its way during this millisecond, handed to the host when it is over.
    leaving: Vec<u8>,
}

impl Serial {
    pub fn new(line: Line, baud: u32) -> Self {
        Self {
            line,
            receiver: Receiver::new(baud),
            meter: Meter::new(baud),
            leaving: Vec::with_capacity(4096),
        }
    }

    pub fn bytes_sent(&self) -> u64 {
        self.line.bytes_sent()
    }

    /// Take what the host has sent, see [`Line::receive`], and feed the core what its driver knows of by now.
    pub fn receive(&mut self, core: &mut Core, due: u64, now_us: u64, ticks: &impl AsFd) -> bool {
        let now_ns = now_us * 1000;
        let begin_ns = (now_ns + WORLD_BEHIND_NS).saturating_sub(TICK_NS);
        let receiver = &mut self.receiver;
        let goes_on = self
            .line
            .receive(due, ticks, |bytes| receiver.arrive(bytes, begin_ns));
        self.receiver.deliver(now_ns, |byte, time_us| {
            core.receive(&[byte], time_us);
        });
        goes_on
    }

    /// Hand over what has left since the last tick, and take what leaves until the next.
    pub fn transmit(&mut self, core: &mut Core, now_us: u64) {
        self.line.send(&self.leaving);
        let mut buffer = [0; 4096];
        let room = buffer.len().min(self.line.room());
        let count = self.meter.take(core, now_us, &mut buffer[..room]);
        self.leaving.clear();
        self.leaving.extend_from_slice(&buffer[..count]);
    }
}

/// The receiving half of the UART with its driver. Times in nanoseconds.
struct Receiver {
    byte_ns: u64,
    silence_ns: u64,
    free_ns: u64,
    arriving: VecDeque<(u64, u8)>,
    /// In the FIFO, where nobody has been told of them.
    waiting: Vec<(u64, u8)>,
}

impl Receiver {
    fn new(baud: u32) -> Self {
        Self {
            byte_ns: BITS_PER_BYTE * NANOSECONDS / u64::from(baud),
            silence_ns: SILENCE_BITS * NANOSECONDS / u64::from(baud),
            free_ns: 0,
            arriving: VecDeque::new(),
            waiting: Vec::with_capacity(HALF_FULL),
        }
    }

    /// Bytes that are on the line one after the other from `begin_ns` on.
    fn arrive(&mut self, bytes: &[u8], begin_ns: u64) {
        for byte in bytes {
            self.free_ns = self.free_ns.max(begin_ns) + self.byte_ns;
            self.arriving.push_back((self.free_ns, *byte));
        }
    }

    /// Give `take` the bytes of which the driver knows by `now_ns`, each with the time in us at which it came.
    fn deliver(&mut self, now_ns: u64, mut take: impl FnMut(u8, u64)) {
        let mut empty = |waiting: &mut Vec<(u64, u8)>| {
            for (time_ns, byte) in waiting.drain(..) {
                take(byte, (time_ns + SERVICE_NS) / 1000);
            }
        };
        while let Some(&(time_ns, byte)) = self.arriving.front() {
            if time_ns > now_ns {
                break;
            }
            self.arriving.pop_front();
            if self.silent_since(time_ns) {
                empty(&mut self.waiting);
            }
            self.waiting.push((time_ns, byte));
            if self.waiting.len() >= HALF_FULL {
                empty(&mut self.waiting);
            }
        }
        if self.silent_since(now_ns) {
            empty(&mut self.waiting);
        }
    }

    /// The last byte that waits came so long before `time_ns` that the silence was noticed.
    fn silent_since(&self, time_ns: u64) -> bool {
        self.waiting
            .last()
            .is_some_and(|(last_ns, _)| last_ns + self.silence_ns <= time_ns)
    }
}

/// Lets as many bytes out of the core as a UART sends in the time that has passed, whole bytes in each tick.
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
        const BYTE: u64 = BITS_PER_BYTE * 1_000_000;
        let elapsed = now_us.saturating_sub(self.last_us).min(100_000) * self.baud;
        self.last_us = now_us;
        self.credit += elapsed;
        let allowed = (self.credit / BYTE).min((elapsed / BYTE).max(1));
        let room = (allowed as usize).min(out.len());
        let count = core.transmit(&mut out[..room]);
        // Neither an idle wire nor a fraction of a byte saves more up for later.
        self.credit = if count < room {
            0
        } else {
            (self.credit - allowed * BYTE).min(BYTE)
        };
        count
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Milliseconds of the ticks at which `count` bytes reach the core that are on the line from 806 us on.
    fn ticks(count: usize) -> Vec<u64> {
        let mut receiver = Receiver::new(crate::options::DEFAULT_BAUD);
        receiver.arrive(&vec![0; count], WORLD_BEHIND_NS);
        let mut heard = vec![];
        for tick in 1..5 {
            receiver.deliver(tick * TICK_NS, |_, _| heard.push(tick));
        }
        heard
    }

    #[test]
    fn a_short_burst_is_told_of_by_the_silence_after_it_and_a_long_one_half_a_fifo_at_a_time() {
        assert_eq!(ticks(1), [1], "after 44 us and 139 us of silence");
        assert_eq!(ticks(8), [2; 8]);
        assert_eq!(ticks(23), [2; 23]);
        // 29 bytes end just before the third tick: of those behind the sixteenth the driver does not know yet.
        let known: Vec<u64> = [vec![2; 16], vec![3; 13]].concat();
        assert_eq!(ticks(29), known);
    }

    #[test]
    fn each_byte_has_the_time_at_which_it_came() {
        let mut receiver = Receiver::new(crate::options::DEFAULT_BAUD);
        receiver.arrive(b"abc", 5_000_000);
        let mut times = vec![];
        receiver.deliver(6_000_000, |byte, time_us| times.push((byte, time_us)));
        assert_eq!(times, [(b'a', 5_044), (b'b', 5_087), (b'c', 5_131)]);
    }
}
