//! Puts segments together from their messages, whatever the order in which these come.
//!
//! A segment is a travel half and a heading half; one that begins a run also needs its start time. Segments
//! ahead of the expected one are kept, so that one lost frame costs one repetition and not the whole window.

use crate::motion::Segment;

/// Segments that are kept while an earlier one is incomplete.
const AHEAD: u16 = 32;
/// Indexes that are never used again after a flush: more than may be on their way when it comes.
const SKIPPED: u16 = 256;

/// What became of a half.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Receipt {
    Stored,
    /// Accepted long ago: the sender missed the acknowledgement.
    Duplicate,
    /// Further ahead than this end keeps; the sender repeats it.
    TooFarAhead,
}

#[derive(Clone, Copy, Debug, Default)]
struct Slot {
    /// Duration in us, jerk in um/s^3.
    travel: Option<(u32, i32)>,
    /// Jerk in urad/s^3, flags.
    heading: Option<(i32, u8)>,
    /// When the run that begins with it starts, firmware time in us.
    start_us: Option<u64>,
}

/// Halves that wait. `next_index` is the number of the segment expected next; it only ever counts up, so that what was
/// sent before a flush and comes after it is known as old.
#[derive(Clone, Debug, Default)]
pub struct SegmentInbox {
    next_index: u16,
    /// Something has come since the last flush.
    used: bool,
    slots: [Slot; AHEAD as usize],
}

impl SegmentInbox {
    pub fn next_index(&self) -> u16 {
        self.next_index
    }

    pub fn put_travel(&mut self, index: u16, duration_us: u32, jerk: i32) -> Receipt {
        self.store(index, |slot| slot.travel = Some((duration_us, jerk)))
    }

    pub fn put_heading(&mut self, index: u16, jerk: i32, flags: u8) -> Receipt {
        self.store(index, |slot| slot.heading = Some((jerk, flags)))
    }

    /// Whether `index` was not accepted yet and is near enough to be kept.
    pub fn is_ahead(&self, index: u16) -> bool {
        index.wrapping_sub(self.next_index) < AHEAD
    }

    /// The start time of the run that begins with `index`.
    pub fn put_start(&mut self, index: u16, start_us: u64) {
        self.store(index, |slot| slot.start_us = Some(start_us));
    }

    /// Whether a half of the expected segment is there: nearly never between two segments.
    pub fn is_begun(&self) -> bool {
        self.slots
            .get(slot_of(self.next_index))
            .is_some_and(|slot| slot.travel.is_some())
    }

    /// The expected segment, if all of it is there. It stays until `take` or `discard`.
    pub fn complete(&self) -> Option<(Segment, Option<u64>)> {
        let slot = self.slots.get(slot_of(self.next_index))?;
        let ((duration_us, jerk_travel), (jerk_heading, flags)) = (slot.travel?, slot.heading?);
        let segment = Segment::new(
            self.next_index,
            duration_us,
            jerk_travel,
            jerk_heading,
            flags,
        );
        if !segment.begins {
            return Some((segment, None));
        }
        slot.start_us.map(|start_us| (segment, Some(start_us)))
    }

    /// The expected segment was accepted: expect the next.
    pub fn take(&mut self) {
        self.discard();
        self.next_index = self.next_index.wrapping_add(1);
    }

    /// The expected segment was refused: forget what came of it.
    pub fn discard(&mut self) {
        if let Some(slot) = self.slots.get_mut(slot_of(self.next_index)) {
            *slot = Slot::default();
        }
    }

    /// Something came at a time when nothing is taken.
    pub fn note_refused(&mut self) {
        self.used = true;
    }

    /// Forget every half, at a stop and when the rover is armed, and all that is still on its way.
    pub fn flush(&mut self) {
        if core::mem::take(&mut self.used) {
            self.next_index = self.next_index.wrapping_add(SKIPPED);
        }
        self.slots = Default::default();
    }

    fn store(&mut self, index: u16, put: impl FnOnce(&mut Slot)) -> Receipt {
        let ahead = index.wrapping_sub(self.next_index);
        if ahead >= 0x8000 {
            return Receipt::Duplicate;
        }
        self.used = true;
        match self.slots.get_mut(slot_of(index)) {
            Some(slot) if ahead < AHEAD => {
                put(slot);
                Receipt::Stored
            }
            _ => Receipt::TooFarAhead,
        }
    }
}

fn slot_of(index: u16) -> usize {
    usize::from(index % AHEAD)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn put_both(inbox: &mut SegmentInbox, index: u16) {
        assert_eq!(inbox.put_heading(index, -5, 0), Receipt::Stored);
        assert_eq!(inbox.put_travel(index, 1000, 7), Receipt::Stored);
    }

    #[test]
    fn halves_may_come_in_any_order_and_twice() {
        let mut inbox = SegmentInbox::default();
        assert!(inbox.complete().is_none());
        inbox.put_heading(0, -5, 2);
        assert!(inbox.complete().is_none());
        inbox.put_heading(0, -5, 2);
        inbox.put_travel(0, 1000, 7);
        let (segment, start) = inbox.complete().unwrap();
        assert_eq!(segment, Segment::new(0, 1000, 7, -5, 2));
        assert_eq!(start, None);
    }

    #[test]
    fn later_segments_wait_for_an_earlier_one_that_was_lost() {
        let mut inbox = SegmentInbox::default();
        put_both(&mut inbox, 1);
        put_both(&mut inbox, 31);
        assert!(inbox.complete().is_none());
        assert_eq!(inbox.put_travel(32, 1000, 0), Receipt::TooFarAhead);
        put_both(&mut inbox, 0);
        inbox.take();
        assert_eq!(inbox.complete().unwrap().0.index, 1);
        inbox.take();
        assert!(inbox.complete().is_none());
    }

    #[test]
    fn an_index_that_was_accepted_before_is_a_duplicate_also_across_the_wrap() {
        let mut inbox = SegmentInbox {
            next_index: 65_535,
            ..SegmentInbox::default()
        };
        put_both(&mut inbox, 65_535);
        put_both(&mut inbox, 0);
        inbox.take();
        assert_eq!(inbox.next_index(), 0);
        assert_eq!(inbox.put_travel(65_535, 1000, 0), Receipt::Duplicate);
        assert_eq!(inbox.complete().unwrap().0.index, 0);
    }

    #[test]
    fn a_begin_segment_waits_for_its_own_start_time() {
        let mut inbox = SegmentInbox::default();
        inbox.put_travel(0, 1000, 7);
        inbox.put_heading(0, 0, 1);
        inbox.put_start(3, 55);
        assert!(inbox.complete().is_none());
        inbox.put_start(0, 66);
        assert_eq!(inbox.complete().unwrap().1, Some(66));
    }

    #[test]
    fn start_times_of_two_runs_that_wait_are_both_kept() {
        let mut inbox = SegmentInbox::default();
        inbox.put_start(0, 66);
        inbox.put_start(1, 77);
        inbox.put_heading(1, 0, 1);
        inbox.put_travel(1, 1000, 7);
        // The older run's half was lost and comes again.
        inbox.put_heading(0, 0, 3);
        inbox.put_travel(0, 1000, 7);
        assert_eq!(inbox.complete().unwrap().1, Some(66));
        inbox.take();
        assert_eq!(inbox.complete().unwrap().1, Some(77));
    }

    #[test]
    fn no_index_that_was_on_its_way_at_a_flush_is_taken_after_it() {
        let mut inbox = SegmentInbox::default();
        put_both(&mut inbox, 0);
        inbox.take();
        put_both(&mut inbox, 1);
        inbox.flush();
        assert!(inbox.complete().is_none());
        for index in 1..=AHEAD {
            assert_eq!(inbox.put_travel(index, 1000, 7), Receipt::Duplicate);
        }
        assert_eq!(inbox.next_index(), 1 + SKIPPED);
        inbox.flush();
        assert_eq!(inbox.next_index(), 1 + SKIPPED, "nothing has come since");
    }
}
