//! The record of a crash: kept, written to flash, told to whoever asks until it is cleared.
//!
//! A crash that repeats itself is written once: a board that crashes at every start does not wear its flash out.

use rover_protocol::messages as m;
use rover_protocol::messages::{crash_event_kind as kind, crash_request_command as command};

use crate::controller::Core;
use crate::crash::{store, CrashEvent, CrashRecord};
use crate::storage::{Flash, StorageOrder};

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
    use crate::crash::EVENTS;
    use crate::storage::{FlashError, BLOCK, CRASH_PAGE};

    const RECORD: CrashRecord = CrashRecord {
        cause: 2,
        task: 3,
        detail: 77,
        program_counter: 0x1000_4321,
        uptime_ms: 123_456,
        stack_bytes: 4_000,
        count: 32,
        events: [CrashEvent {
            time_ms: 1,
            kind: 1,
            detail: 0,
        }; EVENTS],
    };

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
            core.keep_crash(RECORD, &mut flash);
        }
        assert_eq!(flash.erased, 1, "the same crash three times");
        let mut core = Core::new(Default::default());
        core.attach_storage(&mut flash);
        assert_eq!(core.crash, Some(RECORD));
        core.crash_request(command::CLEAR).unwrap();
        core.serve_storage(&mut flash);
        let mut core = Core::new(Default::default());
        core.attach_storage(&mut flash);
        assert_eq!(core.crash, None);
    }
}
