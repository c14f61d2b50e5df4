//! Frames on the serial line: a zero byte, COBS(identifier u16 LE | sequence u8 | payload | CRC-16 LE), a zero byte.
//!
//! A zero byte ends a frame and occurs nowhere else. The one in front ends what noise has put on the line before, so that
//! only a frame that noise has hit itself is lost. The sequence byte counts the frames of one direction; the receiver counts its gaps.

use crate::Message;

/// Most payload that a frame carries: one classic CAN frame.
pub const MAX_PAYLOAD: usize = 8;
/// Identifier, sequence and checksum.
const OVERHEAD: usize = 5;
const MAX_BODY: usize = OVERHEAD + MAX_PAYLOAD;
/// Longest frame on the wire, with the COBS code byte and a zero at both ends.
pub const MAX_FRAME: usize = MAX_BODY + 3;

/// CRC-16/CCITT-FALSE: polynomial 0x1021, start 0xFFFF, not reflected. Check value of "123456789": 0x29B1.
pub fn crc16(bytes: &[u8]) -> u16 {
    bytes
        .iter()
        .fold(0xffff, |crc, byte| crc16_step(crc, *byte))
}

/// One byte of [`crc16`], without a table: 256 entries would cost more flash than the cycles are worth.
fn crc16_step(crc: u16, byte: u8) -> u16 {
    let mut x = (crc >> 8) ^ u16::from(byte);
    x ^= x >> 4;
    (crc << 8) ^ (x << 12) ^ (x << 5) ^ x
}

/// Write a frame with a zero at both ends; returns its length. Payload beyond [`MAX_PAYLOAD`] is cut off.
pub fn encode(identifier: u16, sequence: u8, payload: &[u8], out: &mut [u8; MAX_FRAME]) -> usize {
    let mut body = [0; MAX_BODY];
    let [low, high] = identifier.to_le_bytes();
    let header = [low, high, sequence];
    let checked = header.len() + payload.len().min(MAX_PAYLOAD);
    for (slot, byte) in body
        .iter_mut()
        .zip(header.iter().chain(payload.iter().take(MAX_PAYLOAD)))
    {
        *slot = *byte;
    }
    let crc = body
        .iter()
        .take(checked)
        .fold(0xffff, |crc, byte| crc16_step(crc, *byte));
    for (slot, byte) in body.iter_mut().skip(checked).zip(crc.to_le_bytes()) {
        *slot = byte;
    }
    stuff(&body, checked + 2, out)
}

/// Encode a [`Message`]; returns the length of the frame.
pub fn encode_message<M: Message>(message: &M, sequence: u8, out: &mut [u8; MAX_FRAME]) -> usize {
    let mut payload = [0; 8];
    message.write(&mut payload);
    encode(
        M::ID,
        sequence,
        payload.get(..M::LENGTH).unwrap_or(&payload),
        out,
    )
}

/// COBS of the first `length` bytes of a body, with a zero before and behind. Bodies are so short that a code is never 0xFF.
fn stuff(body: &[u8; MAX_BODY], length: usize, out: &mut [u8; MAX_FRAME]) -> usize {
    *out = [0; MAX_FRAME];
    let mut code_at = 1;
    let mut code: u8 = 1;
    for (i, byte) in body.iter().take(length).enumerate() {
        if *byte == 0 {
            set(out, code_at, code);
            code_at = i + 2;
            code = 1;
        } else {
            set(out, i + 2, *byte);
            code += 1;
        }
    }
    set(out, code_at, code);
    length + 3
}

fn set(out: &mut [u8; MAX_FRAME], at: usize, value: u8) {
    if let Some(slot) = out.get_mut(at) {
        *slot = value;
    }
}

/// A frame whose checksum was right.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame {
    /// CAN identifier.
    pub identifier: u16,
    /// Counts the frames of the sender.
    pub sequence: u8,
    /// Only the first `length` bytes count.
    pub payload: [u8; MAX_PAYLOAD],
    /// At most [`MAX_PAYLOAD`].
    pub length: u8,
}

impl Frame {
    /// The bytes that count.
    pub fn payload(&self) -> &[u8] {
        self.payload
            .get(..usize::from(self.length))
            .unwrap_or(&self.payload)
    }
}

/// Finds frames in a stream of bytes. Counters wrap.
///
/// The bytes between two zeros are one frame; nothing at all between them is no error, so a sender may begin with a
/// zero to flush a line.
#[derive(Clone, Debug, Default)]
pub struct Decoder {
    body: [u8; MAX_BODY],
    /// Bytes of body so far.
    filled: usize,
    /// Bytes to come before the next COBS code byte.
    run: u8,
    /// Whether any byte came since the last zero.
    started: bool,
    /// Longer than any frame: ignore everything up to the next zero.
    overlong: bool,
    /// Sequence byte that the next frame should carry.
    expected: Option<u8>,
    /// Good frames.
    pub frames: u16,
    /// Frames of a plausible length whose checksum was wrong.
    pub checksum_errors: u16,
    /// Frames too short, too long, or ended in the middle of a COBS run. The receiver of the frames may add those
    /// whose identifier or length it does not know.
    pub malformed: u16,
    /// Gaps in the sequence byte, summed modulo 256 each. A sender that starts again counts as a gap too.
    pub lost: u16,
}

impl Decoder {
    /// A receiver that has seen nothing.
    pub fn new() -> Self {
        Self::default()
    }

    /// Take one byte; a frame when it was the zero that ends a good one.
    pub fn push(&mut self, byte: u8) -> Option<Frame> {
        if byte != 0 {
            self.collect(byte);
            return None;
        }
        let started = self.started;
        let complete = !self.overlong && self.run == 0;
        let length = self.filled;
        self.started = false;
        self.overlong = false;
        self.filled = 0;
        self.run = 0;
        if !started {
            return None;
        }
        if !complete || length < OVERHEAD {
            self.malformed = self.malformed.wrapping_add(1);
            return None;
        }
        self.check(length)
    }

    /// Undo COBS as the bytes come: a code byte n stands for a zero (but for the first) and n - 1 bytes behind it.
    fn collect(&mut self, byte: u8) {
        if self.run == 0 {
            self.run = byte - 1;
            if self.started {
                self.append(0);
            }
        } else {
            self.run -= 1;
            self.append(byte);
        }
        self.started = true;
    }

    fn append(&mut self, byte: u8) {
        match self.body.get_mut(self.filled) {
            Some(slot) => {
                *slot = byte;
                self.filled += 1;
            }
            None => self.overlong = true,
        }
    }

    fn check(&mut self, length: usize) -> Option<Frame> {
        let (checked, rest) = self.body.split_at_checked(length - 2)?;
        let (sum, _) = rest.split_first_chunk::<2>()?;
        if crc16(checked) != u16::from_le_bytes(*sum) {
            self.checksum_errors = self.checksum_errors.wrapping_add(1);
            return None;
        }
        let ([low, high, sequence], bytes) = checked.split_first_chunk::<3>()?;
        let mut payload = [0; MAX_PAYLOAD];
        for (slot, byte) in payload.iter_mut().zip(bytes) {
            *slot = *byte;
        }
        if let Some(expected) = self.expected {
            self.lost = self
                .lost
                .wrapping_add(u16::from(sequence.wrapping_sub(expected)));
        }
        self.expected = Some(sequence.wrapping_add(1));
        self.frames = self.frames.wrapping_add(1);
        let length = bytes.len() as u8;
        Some(Frame {
            identifier: u16::from_le_bytes([*low, *high]),
            sequence: *sequence,
            payload,
            length,
        })
    }
}
