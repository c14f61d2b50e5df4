//! Arithmetic with flags (ARMv6-M Architecture Reference Manual, A2.2.1 and A6.4).

/// Negative, zero, carry, overflow.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flags {
    /// Negative.
    pub n: bool,
    /// Zero.
    pub z: bool,
    /// Carry; after a subtraction, no borrow.
    pub c: bool,
    /// Overflow.
    pub v: bool,
}

impl Flags {
    /// Sets N and Z for a result and hands it on.
    #[inline]
    pub fn set_nz(&mut self, result: u32) -> u32 {
        self.n = result >> 31 != 0;
        self.z = result == 0;
        result
    }

    /// AddWithCarry; a subtraction adds the complement with a carry in.
    #[inline]
    pub fn add(&mut self, left: u32, right: u32, carry: bool) -> u32 {
        let (partial, first) = left.overflowing_add(right);
        let (sum, second) = partial.overflowing_add(u32::from(carry));
        self.c = first || second;
        self.v = (left ^ sum) & (right ^ sum) & 0x8000_0000 != 0;
        self.set_nz(sum)
    }

    /// Difference, with all flags; comparisons drop the result.
    #[inline]
    pub fn subtract(&mut self, left: u32, right: u32) -> u32 {
        self.add(left, !right, true)
    }

    /// Shifts by 0 leave the carry as it is.
    #[inline]
    pub fn shift_left(&mut self, value: u32, amount: u32) -> u32 {
        if amount != 0 {
            self.c = amount <= 32 && value >> (32 - amount) & 1 != 0;
        }
        self.set_nz(value.checked_shl(amount).unwrap_or(0))
    }

    /// Logical shift; by 0 the carry stays.
    #[inline]
    pub fn shift_right(&mut self, value: u32, amount: u32) -> u32 {
        if amount != 0 {
            self.c = amount <= 32 && value >> (amount - 1) & 1 != 0;
        }
        self.set_nz(value.checked_shr(amount).unwrap_or(0))
    }

    /// Arithmetic shift; by 0 the carry stays.
    #[inline]
    pub fn shift_right_signed(&mut self, value: u32, amount: u32) -> u32 {
        let amount = amount.min(32);
        if amount != 0 {
            self.c = (value as i32 >> (amount - 1)) & 1 != 0;
        }
        self.set_nz((value as i32 >> amount.min(31)) as u32)
    }

    /// Rotation; by 0 the carry stays.
    #[inline]
    pub fn rotate_right(&mut self, value: u32, amount: u32) -> u32 {
        let result = value.rotate_right(amount & 31);
        if amount != 0 {
            self.c = result >> 31 != 0;
        }
        self.set_nz(result)
    }

    /// Condition of a conditional branch (A6.3).
    #[inline]
    pub fn hold(self, condition: u16) -> bool {
        let base = match condition >> 1 {
            0 => self.z,
            1 => self.c,
            2 => self.n,
            3 => self.v,
            4 => self.c && !self.z,
            5 => self.n == self.v,
            6 => self.n == self.v && !self.z,
            _ => true,
        };
        base != (condition & 1 != 0)
    }

    /// As the upper bits of the program status register.
    pub fn pack(self) -> u32 {
        u32::from(self.n) << 31
            | u32::from(self.z) << 30
            | u32::from(self.c) << 29
            | u32::from(self.v) << 28
    }

    /// From the upper bits of the program status register.
    pub fn unpack(status: u32) -> Self {
        let bit = |index: u32| status >> index & 1 != 0;
        Self {
            n: bit(31),
            z: bit(30),
            c: bit(29),
            v: bit(28),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addition_and_subtraction_set_all_four_flags() {
        let mut flags = Flags::default();
        assert_eq!(flags.add(0x7FFF_FFFF, 1, false), 0x8000_0000);
        assert_eq!(
            flags,
            Flags {
                n: true,
                z: false,
                c: false,
                v: true
            }
        );
        assert_eq!(flags.add(u32::MAX, 1, false), 0);
        assert_eq!(
            flags,
            Flags {
                n: false,
                z: true,
                c: true,
                v: false
            }
        );
        assert_eq!(flags.subtract(3, 5), u32::MAX - 1);
        assert_eq!(
            flags,
            Flags {
                n: true,
                z: false,
                c: false,
                v: false
            },
            "a borrow clears the carry"
        );
        assert_eq!(flags.subtract(5, 5), 0);
        assert_eq!(
            flags,
            Flags {
                n: false,
                z: true,
                c: true,
                v: false
            }
        );
    }

    #[test]
    fn shifts_give_the_last_bit_out_as_carry_and_leave_it_for_zero() {
        let mut flags = Flags {
            c: true,
            ..Flags::default()
        };
        assert_eq!(flags.shift_left(1, 0), 1);
        assert!(flags.c);
        assert_eq!(flags.shift_left(0x8000_0001, 1), 2);
        assert!(flags.c);
        assert_eq!(flags.shift_left(1, 32), 0);
        assert!(flags.c);
        assert_eq!(flags.shift_left(1, 33), 0);
        assert!(!flags.c);
        assert_eq!(flags.shift_right_signed(0x8000_0000, 40), u32::MAX);
        assert!(flags.c);
        assert_eq!(flags.rotate_right(0x0000_0003, 1), 0x8000_0001);
        assert!(flags.c);
    }

    #[test]
    fn each_condition_has_its_opposite() {
        for status in 0..16_u32 {
            let flags = Flags::unpack(status << 28);
            assert_eq!(flags.pack(), status << 28);
            for condition in (0..14).step_by(2) {
                assert_ne!(flags.hold(condition), flags.hold(condition + 1));
            }
            let signed = flags.n == flags.v;
            assert_eq!(flags.hold(10), signed);
            assert_eq!(flags.hold(12), signed && !flags.z);
        }
    }
}
