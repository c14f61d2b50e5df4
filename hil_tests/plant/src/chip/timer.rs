//! The 64-bit microsecond timer with its four alarms (RP2040 datasheet 4.6). rp2040py lets an alarm go off up to a
//! microsecond early, because it arms with the rest of the present microsecond cut off.

use super::clock::NEVER;
use super::CYCLES_PER_US;

#[derive(Default)]
pub struct Timer {
    epoch: u64,
    latched_high: u32,
    target: [u32; 4],
    due: [Option<u64>; 4],
    raised: u32,
    enabled: u32,
    forced: u32,
}

impl Timer {
    /// A timer that has just come out of its reset.
    pub fn start(cycle: u64) -> Self {
        Self {
            epoch: cycle,
            ..Self::default()
        }
    }

    fn micros(&self, cycle: u64) -> u64 {
        (cycle - self.epoch) / CYCLES_PER_US
    }

    /// When the next armed alarm matches.
    pub fn next_due(&self) -> u64 {
        self.due.iter().flatten().copied().min().unwrap_or(NEVER)
    }

    /// Raises the interrupts of alarms that are due.
    pub fn advance(&mut self, cycle: u64) {
        for (index, due) in self.due.iter_mut().enumerate() {
            if due.is_some_and(|due| due <= cycle) {
                *due = None;
                self.raised |= 1 << index;
            }
        }
    }

    /// Interrupt lines 0 to 3.
    pub fn lines(&self) -> u32 {
        (self.raised & self.enabled) | self.forced
    }

    pub fn targets(&self) -> [u32; 4] {
        self.target
    }

    fn armed(&self) -> u32 {
        (0..4)
            .filter(|&index| self.due[index].is_some())
            .fold(0, |bits, index| bits | 1 << index)
    }

    pub fn read(&mut self, offset: u32, cycle: u64) -> u32 {
        let now = self.micros(cycle);
        match offset {
            0x08 => self.latched_high,
            0x0C => {
                self.latched_high = (now >> 32) as u32;
                now as u32
            }
            0x10 | 0x14 | 0x18 | 0x1C => self.target[(offset as usize - 0x10) / 4],
            0x20 => self.armed(),
            0x24 => (now >> 32) as u32,
            0x28 => now as u32,
            0x34 => self.raised,
            0x38 => self.enabled,
            0x3C => self.forced,
            0x40 => self.lines(),
            _ => 0,
        }
    }

    /// `value` after the bus has applied a set, clear or xor alias; `raw` is what was written.
    pub fn write(&mut self, offset: u32, value: u32, raw: u32, cycle: u64) {
        match offset {
            0x10 | 0x14 | 0x18 | 0x1C => {
                let index = (offset as usize - 0x10) / 4;
                let now = self.micros(cycle);
                let wait = u64::from(value.wrapping_sub(now as u32));
                self.target[index] = value;
                self.due[index] = Some((self.epoch + (now + wait) * CYCLES_PER_US).max(cycle));
            }
            0x20 => {
                for index in (0..4).filter(|index| raw & 1 << index != 0) {
                    self.due[index] = None;
                }
            }
            0x34 => self.raised &= !raw,
            0x38 => self.enabled = value & 0xF,
            0x3C => self.forced = value & 0xF,
            _ => {}
        }
    }
}
