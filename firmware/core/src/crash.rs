//! What is known of a crash after the start that follows it: cause, place, task, and what went before.
//!
//! While the firmware runs the board keeps the last events in memory that a reset leaves alone. After a crash it makes a
//! [`CrashRecord`] of them, and the core writes it to a page of flash of its own (`crash_service`).

use crate::storage::{crc32, Flash, FlashError, BLOCK, CRASH_PAGE};

/// Events that are kept.
pub const EVENTS: usize = 32;

const MAGIC: u32 = 0x4352_5652; // "RVRC"
const HEADER: usize = 19;
const EVENT: usize = 7;
const SUM_AT: usize = BLOCK - 4;
const _: () = assert!(HEADER + EVENTS * EVENT <= SUM_AT);

/// Something that the firmware did or met.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CrashEvent {
    /// Since the start.
    pub time_ms: u32,
    /// As in the message CrashEvent.
    pub kind: u8,
    pub detail: u16,
}

/// One crash.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CrashRecord {
    /// As in the message CrashCause.
    pub cause: u8,
    /// As in the message CrashCause.
    pub task: u8,
    pub detail: u16,
    pub program_counter: u32,
    pub uptime_ms: u32,
    /// Most that the stack has held.
    pub stack_bytes: u16,
    /// How many of `events` there are, the oldest first.
    pub count: u8,
    pub events: [CrashEvent; EVENTS],
}

impl CrashRecord {
    /// The same crash again: it came at the same place for the same reason.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        let what = |record: &Self| (record.cause, record.task, record.program_counter);
        what(self) == what(other)
    }

    pub(crate) fn events(&self) -> impl Iterator<Item = &CrashEvent> {
        self.events.iter().take(usize::from(self.count))
    }

    #[cold]
    fn image(&self) -> [u8; BLOCK] {
        let [detail_low, detail_high] = self.detail.to_le_bytes();
        let header = MAGIC
            .to_le_bytes()
            .into_iter()
            .chain([self.cause, self.task, detail_low, detail_high])
            .chain(self.program_counter.to_le_bytes())
            .chain(self.uptime_ms.to_le_bytes())
            .chain(self.stack_bytes.to_le_bytes())
            .chain([self.count]);
        let events = self.events.iter().flat_map(|event| {
            event
                .time_ms
                .to_le_bytes()
                .into_iter()
                .chain([event.kind])
                .chain(event.detail.to_le_bytes())
        });
        let mut block = [0xff; BLOCK];
        for (slot, byte) in block.iter_mut().zip(header.chain(events)) {
            *slot = byte;
        }
        let sum = crc32(block.get(..SUM_AT).unwrap_or(&[]));
        for (slot, byte) in block.iter_mut().skip(SUM_AT).zip(sum.to_le_bytes()) {
            *slot = byte;
        }
        block
    }

    /// None of a page that holds no whole record.
    #[cold]
    fn of_image(block: &[u8; BLOCK]) -> Option<Self> {
        let (content, sum) = block.split_last_chunk::<4>()?;
        let mut reader = Reader(content);
        if crc32(content) != u32::from_le_bytes(*sum) || reader.u32()? != MAGIC {
            return None;
        }
        let mut record = Self {
            cause: reader.u8()?,
            task: reader.u8()?,
            detail: reader.u16()?,
            program_counter: reader.u32()?,
            uptime_ms: reader.u32()?,
            stack_bytes: reader.u16()?,
            count: reader.u8()?.min(EVENTS as u8),
            events: [CrashEvent::default(); EVENTS],
        };
        for event in &mut record.events {
            *event = CrashEvent {
                time_ms: reader.u32()?,
                kind: reader.u8()?,
                detail: reader.u16()?,
            };
        }
        Some(record)
    }
}

/// Numbers out of a row of bytes.
struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (bytes, rest) = self.0.split_first_chunk::<N>()?;
        self.0 = rest;
        Some(*bytes)
    }

    fn u8(&mut self) -> Option<u8> {
        self.take().map(u8::from_le_bytes)
    }

    fn u16(&mut self) -> Option<u16> {
        self.take().map(u16::from_le_bytes)
    }

    fn u32(&mut self) -> Option<u32> {
        self.take().map(u32::from_le_bytes)
    }
}

/// The record that a page holds.
pub(crate) fn load(flash: &mut impl Flash) -> Option<CrashRecord> {
    let mut block = [0; BLOCK];
    flash.read(CRASH_PAGE, &mut block).ok()?;
    CrashRecord::of_image(&block)
}

pub(crate) fn store(flash: &mut impl Flash, record: &CrashRecord) -> Result<(), FlashError> {
    flash.erase(CRASH_PAGE)?;
    flash.program(CRASH_PAGE, &record.image())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record() -> CrashRecord {
        let mut events = [CrashEvent::default(); EVENTS];
        for (number, event) in (0..).zip(&mut events) {
            *event = CrashEvent {
                time_ms: 1_000 * number,
                kind: 1,
                detail: number as u16,
            };
        }
        CrashRecord {
            cause: 2,
            task: 3,
            detail: 77,
            program_counter: 0x1000_4321,
            uptime_ms: 123_456,
            stack_bytes: 4_000,
            count: 32,
            events,
        }
    }

    #[test]
    fn a_record_survives_its_page_and_damage_is_seen() {
        let image = record().image();
        assert_eq!(CrashRecord::of_image(&image), Some(record()));
        for at in 0..BLOCK {
            let mut damaged = image;
            damaged[at] ^= 0x10;
            assert_eq!(CrashRecord::of_image(&damaged), None, "byte {at}");
        }
        assert_eq!(CrashRecord::of_image(&[0xff; BLOCK]), None);
    }
}
