//! Loads and stores of several registers (ARMv6-M Architecture Reference Manual, A5.2 and A6.7).

use super::core::{Bus, Core, Fault, LR, SP};

impl Core {
    /// LDM and STM; returns the cycles.
    pub fn multiple(&mut self, bus: &mut impl Bus, op: u16) -> Result<u64, Fault> {
        let n = usize::from(op >> 8 & 7);
        let mut address = self.r[n];
        let loading = op >> 11 & 1 != 0;
        for register in (0..8).filter(|register| op >> register & 1 != 0) {
            if loading {
                self.r[register] = bus.load(address, 4)?;
            } else {
                bus.store(address, 4, self.r[register])?;
            }
            address = address.wrapping_add(4);
        }
        if !(loading && op >> n & 1 != 0) {
            self.r[n] = address;
        }
        Ok(1 + u64::from((op & 0xFF).count_ones()))
    }

    /// PUSH; returns the cycles.
    pub fn push(&mut self, bus: &mut impl Bus, op: u16) -> Result<u64, Fault> {
        let count = (op & 0x1FF).count_ones();
        let mut address = self.r[SP].wrapping_sub(4 * count);
        self.r[SP] = address;
        for register in (0..8).filter(|register| op >> register & 1 != 0) {
            bus.store(address, 4, self.r[register])?;
            address = address.wrapping_add(4);
        }
        if op >> 8 & 1 != 0 {
            bus.store(address, 4, self.r[LR])?;
        }
        Ok(1 + u64::from(count))
    }

    /// POP, which may be a return; returns the cycles.
    pub fn pop(&mut self, bus: &mut impl Bus, op: u16) -> Result<u64, Fault> {
        let mut address = self.r[SP];
        for register in (0..8).filter(|register| op >> register & 1 != 0) {
            self.r[register] = bus.load(address, 4)?;
            address = address.wrapping_add(4);
        }
        let cycles = 1 + u64::from((op & 0x1FF).count_ones());
        if op >> 8 & 1 == 0 {
            self.r[SP] = address;
            return Ok(cycles);
        }
        let target = bus.load(address, 4)?;
        self.r[SP] = address.wrapping_add(4);
        Ok(cycles + 2 + self.branch(bus, target)?)
    }
}
