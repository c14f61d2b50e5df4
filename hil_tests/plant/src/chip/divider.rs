//! The integer divider of the SIO (RP2040 datasheet 2.3.1.5). Its eight cycles are the caller's to wait for.

const READY: u32 = 1;
const DIRTY: u32 = 2;

/// One core's divider.
#[derive(Clone, Copy, Default)]
pub struct Divider {
    dividend: u32,
    divisor: u32,
    quotient: u32,
    remainder: u32,
    dirty: bool,
}

impl Divider {
    /// Register at `offset` from the SIO's base; None when it is not one of the divider's.
    pub fn read(&mut self, offset: u32) -> Option<u32> {
        Some(match offset {
            0x60 | 0x68 => self.dividend,
            0x64 | 0x6C => self.divisor,
            0x70 => {
                self.dirty = false;
                self.quotient
            }
            0x74 => self.remainder,
            0x78 => READY | if self.dirty { DIRTY } else { 0 },
            _ => return None,
        })
    }

    /// False when `offset` is not one of the divider's.
    pub fn write(&mut self, offset: u32, value: u32) -> bool {
        match offset {
            0x60 | 0x68 => self.dividend = value,
            0x64 | 0x6C => self.divisor = value,
            0x70 => self.quotient = value,
            0x74 => self.remainder = value,
            _ => return false,
        }
        match offset {
            0x60 | 0x64 => self.divide_unsigned(),
            0x68 | 0x6C => self.divide_signed(),
            _ => {}
        }
        self.dirty = true;
        true
    }

    fn divide_unsigned(&mut self) {
        self.quotient = self.dividend.checked_div(self.divisor).unwrap_or(u32::MAX);
        self.remainder = self
            .dividend
            .checked_rem(self.divisor)
            .unwrap_or(self.dividend);
    }

    fn divide_signed(&mut self) {
        let (dividend, divisor) = (self.dividend as i32, self.divisor as i32);
        if divisor == 0 {
            self.quotient = if dividend < 0 { 1 } else { u32::MAX };
            self.remainder = self.dividend;
        } else {
            self.quotient = dividend.wrapping_div(divisor) as u32;
            self.remainder = dividend.wrapping_rem(divisor) as u32;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNSIGNED: (u32, u32) = (0x60, 0x64);
    const SIGNED: (u32, u32) = (0x68, 0x6C);

    fn divide(registers: (u32, u32), dividend: u32, divisor: u32) -> (u32, u32) {
        let mut divider = Divider::default();
        assert!(divider.write(registers.0, dividend) && divider.write(registers.1, divisor));
        (divider.read(0x70).unwrap(), divider.read(0x74).unwrap())
    }

    #[test]
    fn signs_are_those_of_c() {
        assert_eq!(divide(UNSIGNED, 17, 5), (3, 2));
        let (quotient, remainder) = divide(SIGNED, -17_i32 as u32, 5);
        assert_eq!((quotient as i32, remainder as i32), (-3, -2));
        assert_eq!(
            divide(SIGNED, i32::MIN as u32, u32::MAX),
            (i32::MIN as u32, 0)
        );
    }

    #[test]
    fn a_division_by_zero_gives_the_datasheets_values() {
        assert_eq!(divide(UNSIGNED, 17, 0), (u32::MAX, 17));
        assert_eq!(divide(SIGNED, 17, 0), (u32::MAX, 17));
        assert_eq!(divide(SIGNED, -17_i32 as u32, 0), (1, -17_i32 as u32));
    }

    #[test]
    fn reading_the_quotient_makes_it_clean() {
        let mut divider = Divider::default();
        divider.write(0x60, 1);
        assert_eq!(divider.read(0x78), Some(READY | DIRTY));
        divider.read(0x70);
        assert_eq!(divider.read(0x78), Some(READY));
        assert_eq!(divider.read(0x100), None);
    }
}
