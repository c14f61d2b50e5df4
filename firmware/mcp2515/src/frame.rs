//! A classic CAN data frame with an 11-bit identifier, and its image in the chip's buffers.

use crate::registers::NOT_A_DATA_FRAME;

/// SIDH, SIDL, EID8, EID0, DLC and the data (datasheet registers 3-3 to 3-8 and 4-4 to 4-9).
pub const IMAGE: usize = 13;

/// A data frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Frame {
    identifier: u16,
    length: u8,
    data: [u8; 8],
}

impl Frame {
    /// `None` for an identifier of more than 11 bits or more than 8 bytes.
    pub fn new(identifier: u16, payload: &[u8]) -> Option<Self> {
        if identifier > 0x7ff || payload.len() > 8 {
            return None;
        }
        let mut data = [0; 8];
        for (slot, byte) in data.iter_mut().zip(payload) {
            *slot = *byte;
        }
        Some(Self {
            identifier,
            length: payload.len() as u8,
            data,
        })
    }

    /// 11 bits.
    pub fn identifier(&self) -> u16 {
        self.identifier
    }

    /// At most 8 bytes.
    pub fn payload(&self) -> &[u8] {
        self.data
            .get(..usize::from(self.length))
            .unwrap_or(&self.data)
    }

    pub(crate) fn image(&self) -> [u8; IMAGE] {
        let [high, low] = identifier_image(self.identifier);
        let [a, b, c, d, e, f, g, h] = self.data;
        [high, low, 0, 0, self.length, a, b, c, d, e, f, g, h]
    }

    /// `None` for a remote frame or one with an extended identifier. A length code above 8 means 8 (ISO 11898-1).
    pub(crate) fn from_image(image: &[u8; IMAGE]) -> Option<Self> {
        let [high, low, _, _, code, data @ ..] = *image;
        if low & NOT_A_DATA_FRAME != 0 {
            return None;
        }
        let length = (code & 0x0f).min(8);
        let mut kept = [0; 8];
        for (slot, byte) in kept.iter_mut().zip(data).take(usize::from(length)) {
            *slot = byte;
        }
        Some(Self {
            identifier: u16::from(high) << 3 | u16::from(low >> 5),
            length,
            data: kept,
        })
    }
}

/// SIDH and SIDL.
pub fn identifier_image(identifier: u16) -> [u8; 2] {
    [(identifier >> 3) as u8, (identifier << 5) as u8]
}
