//! Arithmetic with flags (ARMv6-M Architecture Reference Manual, A2.2.1 and A6.4).

/// Negative, zero, carry, overflow.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flags {
    pub n: bool,
    pub z: bool,
    pub c: bool,
    pub v: bool,
}

impl Flags {
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

    #[inline]
    pub fn shift_right(&mut self, value: u32, amount: u32) -> u32 {
        if amount != 0 {
            self.c = amount <= 32 && value >> (amount - 1) & 1 != 0;
        }
        self.set_nz(value.checked_shr(amount).unwrap_or(0))
    }

    #[inline]
    pub fn shift_right_signed(&mut self, value: u32, amount: u32) -> u32 {
        let amount = amount.min(32);
        if amount != 0 {
            self.c = (value as i32 >> (amount - 1)) & 1 != 0;
        }
        self.set_nz((value as i32 >> amount.min(31)) as u32)
    }

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

    pub fn pack(self) -> u32 {
        u32::from(self.n) << 31
            | u32::from(self.z) << 30
            | u32::from(self.c) << 29
            | u32::from(self.v) << 28
    }

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
