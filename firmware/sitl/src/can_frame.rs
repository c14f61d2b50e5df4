//! A classic CAN frame with an 11-bit identifier, and how long it keeps the bus.

/// Behind the checksum, never stuffed: delimiter, acknowledgement, its delimiter, end of frame, pause.
const TAIL_BITS: u32 = 1 + 1 + 1 + 7 + 3;
const CRC15: u16 = 0x4599;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CanFrame {
    pub identifier: u16,
    data: [u8; 8],
    length: usize,
}

impl CanFrame {
    /// What is beyond 11 bits or 8 bytes is cut off.
    pub fn new(identifier: u16, payload: &[u8]) -> Self {
        let length = payload.len().min(8);
        let mut data = [0; 8];
        data[..length].copy_from_slice(&payload[..length]);
        Self {
            identifier: identifier & 0x7ff,
            data,
            length,
        }
    }

    pub fn payload(&self) -> &[u8] {
        &self.data[..self.length]
    }

    /// Bit times from the start of the frame to the start of the next one at the earliest, with the stuff bits that
    /// this very content needs (ISO 11898-1: one after five equal bits, from start of frame to the end of the checksum).
    pub fn bits(&self) -> u32 {
        let mut coder = Coder::default();
        coder.push(0, 1);
        coder.push(u64::from(self.identifier), 11);
        // Remote request, identifier extension and the reserved bit are dominant.
        coder.push(0, 3);
        coder.push(self.length as u64, 4);
        for byte in self.payload() {
            coder.push(u64::from(*byte), 8);
        }
        let checksum = coder.checksum;
        coder.push(u64::from(checksum), 15);
        coder.bits + TAIL_BITS
    }
}

/// Counts bits with their stuff bits, and keeps the checksum of the unstuffed ones.
#[derive(Default)]
struct Coder {
    bits: u32,
    checksum: u16,
    last: Option<bool>,
    equal: u32,
}

impl Coder {
    /// The lowest `width` bits of `value`, highest first.
    fn push(&mut self, value: u64, width: u32) {
        for place in (0..width).rev() {
            let bit = value >> place & 1 != 0;
            let carry = (self.checksum >> 14 & 1 != 0) ^ bit;
            self.checksum = self.checksum << 1 & 0x7fff ^ if carry { CRC15 } else { 0 };
            self.send(bit);
        }
    }

    fn send(&mut self, bit: bool) {
        self.bits += 1;
        self.equal = if self.last == Some(bit) {
            self.equal + 1
        } else {
            1
        };
        self.last = Some(bit);
        if self.equal == 5 {
            // The stuff bit is the other one and counts for the next five.
            self.bits += 1;
            self.last = Some(!bit);
            self.equal = 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_has_47_bits_and_8_a_byte_and_at_most_one_stuff_bit_in_four() {
        for length in 0..=8_usize {
            let least = 47 + 8 * length as u32;
            // Known bound: (34 + 8 n - 1) / 4 stuff bits.
            let most = least + (34 + 8 * length as u32 - 1) / 4;
            for fill in [0x00, 0xff, 0x55, 0x78, 0x1e] {
                let bits = CanFrame::new(0x2aa, &[fill; 8][..length]).bits();
                assert!((least..=most).contains(&bits), "{length} {fill} {bits}");
            }
        }
    }

    #[test]
    fn stuff_bits_are_counted_where_five_equal_bits_stand() {
        // By hand: start and identifier 0 are 12 zeros, with 3 control bits and length 0 19 zeros, its checksum 15 zeros:
        // 34 equal bits. A stuff bit after 5, then after each further 4 of the same (its opposite interrupts the run).
        assert_eq!(CanFrame::new(0, &[]).bits(), 34 + 6 + TAIL_BITS);
    }

    #[test]
    fn the_checksum_is_that_of_can() {
        // CRC-15/CAN of "123456789": 0x059E.
        let mut coder = Coder::default();
        for byte in *b"123456789" {
            coder.push(u64::from(byte), 8);
        }
        assert_eq!(coder.checksum, 0x059e);
    }
}
