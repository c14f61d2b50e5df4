//! The instructions of ARMv6-M (Architecture Reference Manual, A5.2 and A6.7) with the cycles of the Cortex-M0+
//! (Technical Reference Manual, table 3-1) and the waits of the RP2040's buses.

use super::core::{Bus, Core, Fault, Sleep, LR, PC, SP};

/// EXC_RETURN values in a branch of a handler begin like this.
const EXCEPTION_RETURN: u32 = 0xF000_0000;
/// Top of the addresses of the processor's own peripherals; of those there is only the system control space.
const PRIVATE: u32 = 0xE;

fn low(op: u16, at: u32) -> usize {
    (op >> at & 7) as usize
}

/// Cycles of an access beyond the instruction's first: none to the single-cycle IO port, three or four through the
/// bridge to the peripherals (RP2040 datasheet 2.1.3), one elsewhere.
#[inline]
fn access_cycles(address: u32, write: bool) -> u64 {
    match address >> 28 {
        0xD => 0,
        4 => 3 + u64::from(write),
        _ => 1,
    }
}

impl Core {
    /// One instruction; returns its cycles.
    #[inline]
    pub fn step(&mut self, bus: &mut impl Bus) -> Result<u64, Fault> {
        let here = self.r[PC];
        let op = bus.fetch(here)?;
        self.r[PC] = here.wrapping_add(2);
        match op >> 11 {
            0b00000..=0b00111 => Ok(self.immediate(op)),
            0b01000 => self.data_processing(bus, op, here),
            0b01001 => {
                let address = (here.wrapping_add(4) & !3).wrapping_add(u32::from(op & 0xFF) << 2);
                self.load(bus, low(op, 8), address, 4)
            }
            0b01010 | 0b01011 => self.register_offset(bus, op),
            0b01100..=0b10001 => self.immediate_offset(bus, op),
            0b10010 | 0b10011 => {
                let address = self.r[SP].wrapping_add(u32::from(op & 0xFF) << 2);
                if op >> 11 & 1 != 0 {
                    self.load(bus, low(op, 8), address, 4)
                } else {
                    self.store(bus, self.r[low(op, 8)], address, 4)
                }
            }
            0b10100 => {
                self.r[low(op, 8)] =
                    (here.wrapping_add(4) & !3).wrapping_add(u32::from(op & 0xFF) << 2);
                Ok(1)
            }
            0b10101 => {
                self.r[low(op, 8)] = self.r[SP].wrapping_add(u32::from(op & 0xFF) << 2);
                Ok(1)
            }
            0b10110 | 0b10111 => self.miscellaneous(bus, op),
            0b11000 | 0b11001 => self.multiple(bus, op),
            0b11010 | 0b11011 => match op >> 8 & 0xF {
                0xE => Err(Fault::Hard),
                0xF => {
                    self.nvic.request_svcall();
                    self.check = true;
                    Ok(1)
                }
                condition if self.flags.hold(condition) => {
                    let offset = i32::from(op as i8) << 1;
                    self.r[PC] = here.wrapping_add(4).wrapping_add_signed(offset);
                    Ok(2)
                }
                _ => Ok(1),
            },
            0b11100 => {
                let offset = i32::from((op << 5) as i16) >> 4;
                self.r[PC] = here.wrapping_add(4).wrapping_add_signed(offset);
                Ok(2)
            }
            0b11110 => self.wide(bus, op, here),
            _ => Err(Fault::Hard),
        }
    }

    /// Shifts, additions, moves and comparisons with small numbers.
    #[inline]
    fn immediate(&mut self, op: u16) -> u64 {
        let (d, m) = (low(op, 0), low(op, 3));
        let five = u32::from(op >> 6 & 31);
        let eight = u32::from(op & 0xFF);
        let n = low(op, 8);
        match op >> 11 {
            0 => self.r[d] = self.flags.shift_left(self.r[m], five),
            1 => {
                let amount = if five == 0 { 32 } else { five };
                self.r[d] = self.flags.shift_right(self.r[m], amount);
            }
            2 => {
                let amount = if five == 0 { 32 } else { five };
                self.r[d] = self.flags.shift_right_signed(self.r[m], amount);
            }
            3 => {
                let right = if op >> 10 & 1 != 0 {
                    u32::from(op >> 6 & 7)
                } else {
                    self.r[low(op, 6)]
                };
                self.r[d] = if op >> 9 & 1 != 0 {
                    self.flags.subtract(self.r[m], right)
                } else {
                    self.flags.add(self.r[m], right, false)
                };
            }
            4 => self.r[n] = self.flags.set_nz(eight),
            5 => {
                self.flags.subtract(self.r[n], eight);
            }
            6 => self.r[n] = self.flags.add(self.r[n], eight, false),
            _ => self.r[n] = self.flags.subtract(self.r[n], eight),
        }
        1
    }

    fn data_processing(&mut self, bus: &mut impl Bus, op: u16, here: u32) -> Result<u64, Fault> {
        if op >> 10 & 1 != 0 {
            return self.high_registers(bus, op, here);
        }
        let (d, m) = (low(op, 0), low(op, 3));
        let (left, right) = (self.r[d], self.r[m]);
        let amount = right & 0xFF;
        let carry = self.flags.c;
        let flags = &mut self.flags;
        let result = match op >> 6 & 0xF {
            0x0 => flags.set_nz(left & right),
            0x1 => flags.set_nz(left ^ right),
            0x2 => flags.shift_left(left, amount),
            0x3 => flags.shift_right(left, amount),
            0x4 => flags.shift_right_signed(left, amount),
            0x5 => flags.add(left, right, carry),
            0x6 => flags.add(left, !right, carry),
            0x7 => flags.rotate_right(left, amount),
            0x8 => {
                flags.set_nz(left & right);
                left
            }
            0x9 => flags.subtract(0, right),
            0xA => {
                flags.subtract(left, right);
                left
            }
            0xB => {
                flags.add(left, right, false);
                left
            }
            0xC => flags.set_nz(left | right),
            0xD => flags.set_nz(left.wrapping_mul(right)),
            0xE => flags.set_nz(left & !right),
            _ => flags.set_nz(!right),
        };
        self.r[d] = result;
        Ok(1)
    }

    fn high_registers(&mut self, bus: &mut impl Bus, op: u16, here: u32) -> Result<u64, Fault> {
        let d = usize::from(op >> 4 & 8 | op & 7);
        let m = usize::from(op >> 3 & 0xF);
        let read = |core: &Self, register: usize| {
            if register == PC {
                here.wrapping_add(4)
            } else {
                core.r[register]
            }
        };
        let right = read(self, m);
        match op >> 8 & 3 {
            0 => {
                let sum = read(self, d).wrapping_add(right);
                Ok(self.write_register(d, sum))
            }
            1 => {
                self.flags.subtract(read(self, d), right);
                Ok(1)
            }
            2 => Ok(self.write_register(d, right)),
            _ => {
                let next = self.r[PC];
                if op >> 7 & 1 != 0 {
                    self.r[LR] = next | 1;
                    self.r[PC] = right & !1;
                    return Ok(2);
                }
                Ok(2 + self.branch(bus, right)?)
            }
        }
    }

    fn write_register(&mut self, register: usize, value: u32) -> u64 {
        match register {
            PC => {
                self.r[PC] = value & !1;
                2
            }
            SP => {
                self.r[SP] = value & !3;
                1
            }
            _ => {
                self.r[register] = value;
                1
            }
        }
    }

    /// BX and POP into the program counter; returns further cycles.
    pub fn branch(&mut self, bus: &mut impl Bus, target: u32) -> Result<u64, Fault> {
        if self.handler && target >= EXCEPTION_RETURN {
            return self.return_from_exception(bus, target);
        }
        if target & 1 == 0 {
            return Err(Fault::Hard);
        }
        self.r[PC] = target & !1;
        Ok(0)
    }

    #[inline]
    fn load(
        &mut self,
        bus: &mut impl Bus,
        register: usize,
        address: u32,
        size: u32,
    ) -> Result<u64, Fault> {
        self.r[register] = if address >> 28 == PRIVATE {
            self.nvic.read(address & 0xFFF, self.exception)
        } else {
            bus.load(address, size)?
        };
        Ok(1 + access_cycles(address, false))
    }

    #[inline]
    fn store(
        &mut self,
        bus: &mut impl Bus,
        value: u32,
        address: u32,
        size: u32,
    ) -> Result<u64, Fault> {
        if address >> 28 == PRIVATE {
            self.nvic.write(address & 0xFFF, value);
            self.check = true;
        } else {
            bus.store(address, size, value)?;
        }
        Ok(1 + access_cycles(address, true))
    }

    #[inline]
    fn register_offset(&mut self, bus: &mut impl Bus, op: u16) -> Result<u64, Fault> {
        let t = low(op, 0);
        let address = self.r[low(op, 3)].wrapping_add(self.r[low(op, 6)]);
        let value = self.r[t];
        match op >> 9 & 7 {
            0 => self.store(bus, value, address, 4),
            1 => self.store(bus, value, address, 2),
            2 => self.store(bus, value, address, 1),
            3 => {
                let cycles = self.load(bus, t, address, 1)?;
                self.r[t] = i32::from(self.r[t] as i8) as u32;
                Ok(cycles)
            }
            4 => self.load(bus, t, address, 4),
            5 => self.load(bus, t, address, 2),
            6 => self.load(bus, t, address, 1),
            _ => {
                let cycles = self.load(bus, t, address, 2)?;
                self.r[t] = i32::from(self.r[t] as i16) as u32;
                Ok(cycles)
            }
        }
    }

    #[inline]
    fn immediate_offset(&mut self, bus: &mut impl Bus, op: u16) -> Result<u64, Fault> {
        let t = low(op, 0);
        let base = self.r[low(op, 3)];
        let offset = u32::from(op >> 6 & 31);
        let size = match op >> 12 {
            6 => 4,
            7 => 1,
            _ => 2,
        };
        let address = base.wrapping_add(offset * size);
        if op >> 11 & 1 != 0 {
            self.load(bus, t, address, size)
        } else {
            self.store(bus, self.r[t], address, size)
        }
    }

    fn miscellaneous(&mut self, bus: &mut impl Bus, op: u16) -> Result<u64, Fault> {
        let (d, m) = (low(op, 0), low(op, 3));
        match op >> 6 & 0x3F {
            0x00 | 0x01 => self.r[SP] = self.r[SP].wrapping_add(u32::from(op & 0x7F) << 2),
            0x02 | 0x03 => self.r[SP] = self.r[SP].wrapping_sub(u32::from(op & 0x7F) << 2),
            0x08 => self.r[d] = i32::from(self.r[m] as i16) as u32,
            0x09 => self.r[d] = i32::from(self.r[m] as i8) as u32,
            0x0A => self.r[d] = self.r[m] & 0xFFFF,
            0x0B => self.r[d] = self.r[m] & 0xFF,
            0x10..=0x17 => return self.push(bus, op),
            0x19 if op & 0x20 != 0 => {
                self.masked = op & 0x10 != 0;
                self.check = true;
            }
            0x28 => self.r[d] = self.r[m].swap_bytes(),
            0x29 => self.r[d] = self.r[m].swap_bytes().rotate_left(16),
            0x2B => self.r[d] = i32::from((self.r[m] as u16).swap_bytes() as i16) as u32,
            0x30..=0x37 => return self.pop(bus, op),
            0x3C..=0x3F if op & 0xF == 0 => return Ok(self.hint(op)),
            // BKPT without a debugger, and what is not defined.
            _ => return Err(Fault::Hard),
        }
        Ok(1)
    }

    fn hint(&mut self, op: u16) -> u64 {
        match op >> 4 & 0xF {
            2 if self.event => self.event = false,
            2 => self.sleep = Sleep::Event,
            3 => self.sleep = Sleep::Interrupt,
            4 => self.event = true,
            _ => return 1,
        }
        2
    }

    fn wide(&mut self, bus: &mut impl Bus, op: u16, here: u32) -> Result<u64, Fault> {
        let second = bus.fetch(here.wrapping_add(2))?;
        self.r[PC] = here.wrapping_add(4);
        if second >> 14 == 3 && second >> 12 & 1 == 1 {
            let sign = u32::from(op >> 10 & 1);
            let i1 = 1 ^ u32::from(second >> 13 & 1) ^ sign;
            let i2 = 1 ^ u32::from(second >> 11 & 1) ^ sign;
            let offset = sign << 24
                | i1 << 23
                | i2 << 22
                | u32::from(op & 0x3FF) << 12
                | u32::from(second & 0x7FF) << 1;
            let signed = (offset << 7) as i32 >> 7;
            self.r[LR] = self.r[PC] | 1;
            self.r[PC] = self.r[PC].wrapping_add_signed(signed);
            return Ok(3);
        }
        let number = u32::from(second & 0xFF);
        match op {
            0xF380..=0xF38F => self.set_special(number, self.r[usize::from(op & 0xF)]),
            0xF3EF => self.r[usize::from(second >> 8 & 0xF)] = self.special(number),
            0xF3BF => {}
            _ => return Err(Fault::Hard),
        }
        Ok(3)
    }
}

#[cfg(test)]
#[path = "thumb_tests.rs"]
mod tests;
