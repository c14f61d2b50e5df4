//! The parts of the SIO that firmware uses all the time (RP2040 datasheet 2.3.1): divider, spinlocks, and the output
//! registers, of which Python hears only when they change.

use super::divider::Divider;

pub const CPUID: u32 = 0x000;
pub const GPIO_OUT: u32 = 0x010;
pub const GPIO_OE: u32 = 0x020;
const SPINLOCKS: std::ops::RangeInclusive<u32> = 0x100..=0x17C;
const SPINLOCK_STATE: u32 = 0x05C;
const PINS: u32 = 0x3FFF_FFFF;

#[derive(Default)]
pub struct Sio {
    divider: Divider,
    locks: u32,
    output: u32,
    enable: u32,
}

/// What a write has led to.
pub enum Written {
    /// Nothing that anyone else must know of.
    Done,
    /// A register of the pins has this value now.
    Pins { register: u32, value: u32 },
    /// Not a register that is kept here.
    Elsewhere,
}

impl Sio {
    /// None: not a register that is kept here.
    pub fn read(&mut self, offset: u32) -> Option<u32> {
        if SPINLOCKS.contains(&offset) {
            let lock = 1 << ((offset - 0x100) / 4);
            let taken = self.locks & lock != 0;
            self.locks |= lock;
            return Some(if taken { 0 } else { lock });
        }
        match offset {
            CPUID => Some(0),
            GPIO_OUT => Some(self.output),
            GPIO_OE => Some(self.enable),
            SPINLOCK_STATE => Some(self.locks),
            _ => self.divider.read(offset),
        }
    }

    pub fn write(&mut self, offset: u32, value: u32) -> Written {
        if SPINLOCKS.contains(&offset) {
            self.locks &= !(1 << ((offset - 0x100) / 4));
            return Written::Done;
        }
        let register = offset & !0xF;
        let before = match register {
            GPIO_OUT => self.output,
            GPIO_OE => self.enable,
            _ if self.divider.write(offset, value) => return Written::Done,
            _ => return Written::Elsewhere,
        };
        let after = PINS
            & match offset & 0xF {
                0x4 => before | value,
                0x8 => before & !value,
                0xC => before ^ value,
                _ => value,
            };
        if register == GPIO_OUT {
            self.output = after;
        } else {
            self.enable = after;
        }
        if before == after {
            Written::Done
        } else {
            Written::Pins {
                register,
                value: after,
            }
        }
    }
}
