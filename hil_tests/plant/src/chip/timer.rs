//! The 64-bit microsecond timer with its four alarms (RP2040 datasheet 4.6). rp2040py lets an alarm go off up to a
//! microsecond early, because it arms with the rest of the present microsecond cut off.

use super::{CYCLES_PER_US, NEVER};

/// Counter and alarms since the last reset.
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

    /// What each alarm was last set to, low 32 bits of microseconds.
    pub fn targets(&self) -> [u32; 4] {
        self.target
    }

    fn armed(&self) -> u32 {
        (0..4)
            .filter(|&index| self.due[index].is_some())
            .fold(0, |bits, index| bits | 1 << index)
    }

    /// Register at `offset`, at that cycle.
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

#[cfg(test)]
mod tests {
    use super::*;

    const ALARM_1: u32 = 0x14;

    fn us(time: u64) -> u64 {
        time * CYCLES_PER_US
    }

    #[test]
    fn an_alarm_goes_off_in_the_cycle_in_which_its_microsecond_begins() {
        let mut timer = Timer::start(us(50));
        timer.write(0x38, 0xF, 0xF, us(50));
        timer.write(ALARM_1, 10, 10, us(50));
        assert_eq!(timer.next_due(), us(60));
        timer.advance(us(60) - 1);
        assert_eq!(timer.lines(), 0);
        timer.advance(us(60));
        assert_eq!(timer.lines(), 1 << 1);
        assert_eq!(timer.next_due(), NEVER);
        timer.write(0x34, 1 << 1, 1 << 1, us(61));
        assert_eq!(timer.lines(), 0);
    }

    #[test]
    fn a_target_in_the_past_waits_for_the_counter_to_come_round() {
        let mut timer = Timer::start(0);
        timer.write(ALARM_1, 5, 5, us(10));
        assert_eq!(timer.next_due(), us(10 + (1 << 32) - 5));
    }

    #[test]
    fn a_disarmed_alarm_stays_silent() {
        let mut timer = Timer::start(0);
        timer.write(ALARM_1, 5, 5, 0);
        assert_eq!(timer.read(0x20, 0), 1 << 1);
        timer.write(0x20, 0, 1 << 1, 0);
        timer.advance(us(10));
        assert_eq!(timer.read(0x34, us(10)), 0);
    }

    #[test]
    fn the_low_word_latches_the_high_one() {
        let mut timer = Timer::start(0);
        let late = us((7 << 32) + 3);
        assert_eq!(timer.read(0x0C, late), 3);
        assert_eq!(timer.read(0x08, us(9 << 32)), 7);
        assert_eq!(timer.read(0x24, us(9 << 32)), 9);
    }
}
