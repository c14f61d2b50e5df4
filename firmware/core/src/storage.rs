//! Parameters that survive power loss at any moment: two pages of flash, written in turn.
//!
//! A save erases the page that does not hold the newest image and programs the new image there, with a sequence number
//! one higher and a checksum over all of it. Until the last byte is in place the other page still holds the old image
//! unharmed; from then on the higher sequence number wins. So there is the old set or the new set, never neither.
//!
//! The image holds pairs of identifier and value, so that firmware with more or fewer parameters reads it too: what it
//! does not know or finds out of range keeps its default.

use crate::parameters::{Parameters, COUNT, DEFINITIONS};

/// Pages that are used; each is erased as a whole.
pub const PAGES: usize = 2;
/// The page behind them is for the record of a crash, see [`crate::crash`].
pub const CRASH_PAGE: usize = PAGES;
/// Bytes that are programmed at once: a page program of the usual QSPI flash.
pub const BLOCK: usize = 256;

const MAGIC: u32 = 0x5052_5652; // "RVRP"
/// Magic, sequence, number of pairs.
const HEADER: usize = 10;
const PAIR: usize = 6;
const IMAGE: usize = HEADER + PAIR * COUNT + 4;

// One block keeps the write as short as it can be. More parameters need a second one.
const _: () = assert!(IMAGE <= BLOCK);

/// The flash did not take what it was given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FlashError;

/// Pages of flash that the board gives to parameters and crash record.
pub trait Flash {
    /// Set every byte of the page to 0xFF.
    fn erase(&mut self, page: usize) -> Result<(), FlashError>;
    /// Write the first block of an erased page.
    fn program(&mut self, page: usize, block: &[u8; BLOCK]) -> Result<(), FlashError>;
    /// Read the first block of a page.
    fn read(&mut self, page: usize, block: &mut [u8; BLOCK]) -> Result<(), FlashError>;
}

/// What a ParameterCommand wants of the board's flash.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum StorageOrder {
    Save,
    Load,
    /// Forget the crash record.
    ClearCrash,
}

impl StorageOrder {
    /// False when the flash failed or holds nothing.
    pub(crate) fn carry_out(self, parameters: &mut Parameters, flash: &mut impl Flash) -> bool {
        match self {
            Self::Save => save(flash, parameters).is_ok(),
            Self::Load => match load(flash) {
                Some(loaded) => {
                    *parameters = loaded;
                    true
                }
                None => false,
            },
            Self::ClearCrash => flash.erase(CRASH_PAGE).is_ok(),
        }
    }
}

/// The newest set that is whole, None when there is none.
pub fn load(flash: &mut impl Flash) -> Option<Parameters> {
    let (_, _, block) = newest(flash)?;
    let mut parameters = Parameters::default();
    for pair in pairs(&block)?.chunks_exact(PAIR) {
        let (identifier, value) = pair.split_first_chunk::<2>()?;
        let (value, _) = value.split_first_chunk::<4>()?;
        // One that is unknown or out of range here keeps its default.
        let _ = parameters.set(u16::from_le_bytes(*identifier), i32::from_le_bytes(*value));
    }
    Some(parameters)
}

/// Write the set so that it is there whole, or the one before it still is; read it back.
pub fn save(flash: &mut impl Flash, parameters: &Parameters) -> Result<(), FlashError> {
    let (page, sequence) = match newest(flash) {
        Some((page, sequence, _)) => ((page + 1) % PAGES, sequence.wrapping_add(1)),
        None => (0, 1),
    };
    let block = image(parameters, sequence);
    flash.erase(page)?;
    flash.program(page, &block)?;
    let mut written = [0; BLOCK];
    flash.read(page, &mut written)?;
    match written == block {
        true => Ok(()),
        false => Err(FlashError),
    }
}

/// Page, sequence number and content of the newest image that is whole.
fn newest(flash: &mut impl Flash) -> Option<(usize, u32, [u8; BLOCK])> {
    let mut best: Option<(usize, u32, [u8; BLOCK])> = None;
    for page in 0..PAGES {
        let mut block = [0; BLOCK];
        if flash.read(page, &mut block).is_err() {
            continue;
        }
        let Some(sequence) = check(&block) else {
            continue;
        };
        let newer = best.is_none_or(|(_, other, _)| sequence.wrapping_sub(other) < 1 << 31);
        if newer {
            best = Some((page, sequence, block));
        }
    }
    best
}

/// Sequence number of an image that is whole.
fn check(block: &[u8; BLOCK]) -> Option<u32> {
    let (magic, rest) = block.split_first_chunk::<4>()?;
    let (sequence, _) = rest.split_first_chunk::<4>()?;
    let length = HEADER + pairs(block)?.len();
    let (sum, _) = block.get(length..)?.split_first_chunk::<4>()?;
    let whole = u32::from_le_bytes(*magic) == MAGIC
        && crc32(block.get(..length)?) == u32::from_le_bytes(*sum);
    whole.then_some(u32::from_le_bytes(*sequence))
}

/// The pairs' bytes, None when their number cannot be right.
fn pairs(block: &[u8; BLOCK]) -> Option<&[u8]> {
    let (count, _) = block.get(8..)?.split_first_chunk::<2>()?;
    let length = usize::from(u16::from_le_bytes(*count)) * PAIR;
    block.get(HEADER..HEADER + length)
}

fn image(parameters: &Parameters, sequence: u32) -> [u8; BLOCK] {
    let mut block = [0xff; BLOCK];
    let header = MAGIC
        .to_le_bytes()
        .into_iter()
        .chain(sequence.to_le_bytes())
        .chain((COUNT as u16).to_le_bytes());
    let pairs = DEFINITIONS.iter().flat_map(|definition| {
        let identifier = definition.parameter as u16;
        let value = parameters.get(identifier).unwrap_or(definition.default);
        identifier
            .to_le_bytes()
            .into_iter()
            .chain(value.to_le_bytes())
    });
    for (slot, byte) in block.iter_mut().zip(header.chain(pairs)) {
        *slot = byte;
    }
    let sum = crc32(block.get(..IMAGE - 4).unwrap_or(&block)).to_le_bytes();
    for (slot, byte) in block.iter_mut().skip(IMAGE - 4).zip(sum) {
        *slot = byte;
    }
    block
}

/// The CRC-32 of zlib, bit by bit: it runs a few times in a start.
pub(crate) fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| {
            (crc >> 1) ^ (0xedb8_8320 & (crc & 1).wrapping_neg())
        })
    })
}

#[cfg(test)]
#[path = "storage_tests.rs"]
mod tests;
