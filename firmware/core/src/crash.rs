//! What is known of a crash after the start that follows it: cause, place, task, and what went before.
//!
//! While the firmware runs the board keeps the last events in memory that a reset leaves alone ([`Core::take_event`]).
//! After a crash it makes a [`CrashRecord`] of them, the core writes it to a page of flash of its own, and tells it to
//! whoever asks until it is cleared. A crash that repeats itself is written once: a board that crashes at every start
//! does not wear its flash out.

use rover_protocol::messages as m;
use rover_protocol::messages::{crash_event_kind as kind, crash_request_command as command};

use crate::controller::Core;
use crate::storage::{crc32, Flash, FlashError, StorageOrder, BLOCK, CRASH_PAGE};

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
    fn is_like(&self, other: &Self) -> bool {
        let what = |record: &Self| (record.cause, record.task, record.program_counter);
        what(self) == what(other)
    }

    fn events(&self) -> impl Iterator<Item = &CrashEvent> {
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

fn store(flash: &mut impl Flash, record: &CrashRecord) -> Result<(), FlashError> {
    flash.erase(CRASH_PAGE)?;
    flash.program(CRASH_PAGE, &record.image())
}

impl Core {
    /// There was a crash before this start. Keeps it, and writes it to flash unless it is the one that is there. Once,
    /// after [`Core::attach_storage`] and before the first tick.
    #[cold]
    pub fn keep_crash(&mut self, record: CrashRecord, flash: &mut impl Flash) {
        let known = self.crash.is_some_and(|kept| kept.is_like(&record));
        if !known && store(flash, &record).is_err() {
            self.log
                .line("the crash record could not be written to flash");
        }
        self.crash = Some(record);
    }

    /// What happened in the last tick, one after the other, for the board to keep.
    pub fn take_event(&mut self) -> Option<CrashEvent> {
        self.events.pop_front()
    }

    pub(crate) fn note_event(&mut self, kind: u8, detail: u16) {
        let time_ms = self.now_us.checked_div(1000).unwrap_or(0) as u32;
        // A board that does not take them has none to lose.
        let _ = self.events.push_back(CrashEvent {
            time_ms,
            kind,
            detail,
        });
    }

    /// The events in a change of State.
    pub(crate) fn note_change(&mut self, before: &m::State, now: &m::State) {
        if (before.state, before.cause) != (now.state, now.cause) {
            let detail = u16::from_le_bytes([now.state, now.cause]);
            self.note_event(kind::STATE, detail);
        }
        let changed = before.faults ^ now.faults;
        for code in (0..16_u16).filter(|code| changed >> code & 1 != 0) {
            let begins = now.faults >> code & 1 != 0;
            let kind = if begins {
                kind::FAULT
            } else {
                kind::FAULT_OVER
            };
            self.note_event(kind, code);
        }
    }

    /// Tell the record, or forget it first; not while armed, as erasing takes the processor away like a save.
    pub(crate) fn crash_request(&mut self, wanted: u8) -> Option<()> {
        match wanted {
            command::READ => self.crash_told = Some(0),
            command::CLEAR => {
                if !self.supervisor.is_powered() && self.storage_order.is_none() {
                    self.crash = None;
                    self.storage_order = self.has_storage.then_some(StorageOrder::ClearCrash);
                }
                self.crash_told = Some(0);
            }
            _ => return None,
        }
        Some(())
    }

    /// A piece of the answer each tick: cause, time, then the events.
    pub(crate) fn tell_crash(&mut self) {
        let Some(piece) = self.crash_told.filter(|_| self.link.has_urgent_room()) else {
            return;
        };
        self.crash_told = piece.checked_add(1);
        let Some(record) = &self.crash else {
            self.link.send_urgent(&m::CrashCause::default());
            self.crash_told = None;
            return;
        };
        match piece.checked_sub(2) {
            None if piece == 0 => self.link.send_urgent(&m::CrashCause {
                cause: record.cause,
                task: record.task,
                detail: record.detail,
                program_counter: record.program_counter,
            }),
            None => self.link.send_urgent(&m::CrashTime {
                uptime: record.uptime_ms,
                stack: record.stack_bytes,
                events: record.count,
            }),
            Some(index) => match record.events().nth(usize::from(index)) {
                Some(event) => self.link.send_urgent(&m::CrashEvent {
                    index,
                    kind: event.kind,
                    detail: event.detail,
                    time: event.time_ms,
                }),
                None => self.crash_told = None,
            },
        }
    }
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

    struct Pages {
        blocks: [[u8; BLOCK]; CRASH_PAGE + 1],
        erased: u32,
    }

    impl Flash for Pages {
        fn erase(&mut self, page: usize) -> Result<(), FlashError> {
            self.blocks[page] = [0xff; BLOCK];
            self.erased += 1;
            Ok(())
        }

        fn program(&mut self, page: usize, block: &[u8; BLOCK]) -> Result<(), FlashError> {
            self.blocks[page] = *block;
            Ok(())
        }

        fn read(&mut self, page: usize, block: &mut [u8; BLOCK]) -> Result<(), FlashError> {
            *block = self.blocks[page];
            Ok(())
        }
    }

    #[test]
    fn a_crash_is_kept_over_starts_written_once_and_cleared_by_command() {
        let mut flash = Pages {
            blocks: [[0xff; BLOCK]; CRASH_PAGE + 1],
            erased: 0,
        };
        for _ in 0..3 {
            let mut core = Core::new(Default::default());
            core.attach_storage(&mut flash);
            core.keep_crash(record(), &mut flash);
        }
        assert_eq!(flash.erased, 1, "the same crash three times");
        let mut core = Core::new(Default::default());
        core.attach_storage(&mut flash);
        assert_eq!(core.crash, Some(record()));
        core.crash_request(command::CLEAR).unwrap();
        core.serve_storage(&mut flash);
        let mut core = Core::new(Default::default());
        core.attach_storage(&mut flash);
        assert_eq!(core.crash, None);
    }
}
