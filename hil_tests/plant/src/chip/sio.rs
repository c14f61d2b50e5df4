//! The parts of the SIO that firmware uses all the time (RP2040 datasheet 2.3.1): divider, spinlocks, and the output
//! registers, of which Python hears only when they change.

use super::divider::Divider;

/// Number of the core that reads it.
pub const CPUID: u32 = 0x000;
/// Output levels; set, clear and xor follow it.
pub const GPIO_OUT: u32 = 0x010;
/// Output enables; likewise.
pub const GPIO_OE: u32 = 0x020;
const SPINLOCKS: std::ops::RangeInclusive<u32> = 0x100..=0x17C;
const SPINLOCK_STATE: u32 = 0x05C;
const PINS: u32 = 0x3FFF_FFFF;

/// The registers of one core.
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
    Pins {
        /// Its offset.
        register: u32,
        /// What it holds.
        value: u32,
    },
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

    /// Register at `offset` from the SIO's base.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spinlock_is_taken_by_its_first_reader_until_it_is_written() {
        let mut sio = Sio::default();
        assert_eq!(sio.read(0x10C), Some(1 << 3));
        assert_eq!(sio.read(0x10C), Some(0));
        assert_eq!(sio.read(SPINLOCK_STATE), Some(1 << 3));
        sio.write(0x10C, 0);
        assert_eq!(sio.read(0x10C), Some(1 << 3));
    }

    #[test]
    fn pins_are_told_of_changes_only() {
        let mut sio = Sio::default();
        let told = |written| matches!(written, Written::Pins { .. });
        assert!(told(sio.write(GPIO_OUT + 4, 1 << 25)));
        assert!(!told(sio.write(GPIO_OUT + 4, 1 << 25)));
        assert!(told(sio.write(GPIO_OUT + 0xC, 1 << 25)));
        assert_eq!(sio.read(GPIO_OUT), Some(0));
        assert!(told(sio.write(GPIO_OE, u32::MAX)));
        assert_eq!(sio.read(GPIO_OE), Some(PINS), "there are thirty pins");
        assert!(matches!(sio.write(0x004, 1), Written::Elsewhere));
    }
}
