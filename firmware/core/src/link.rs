//! Both directions of the wire: frames out of bytes, and two bounded queues of frames that wait to be sent.
//!
//! Frames wait as messages and become bytes only when the wire takes them. So an urgent one overtakes telemetry, and
//! the turnaround in a clock reply is the true one.

use heapless::Deque;
use rover_protocol::framing::{self, Decoder, Frame, MAX_FRAME};
use rover_protocol::messages::{ClockReply, LinkStatistics, State};
use rover_protocol::Message;

use crate::clock;

/// A bus node is expected to show life, companion or not.
pub const BEAT_US: u64 = 1_000_000;
const URGENT: usize = 32;
const ROUTINE: usize = 32;

/// A message on its way out: identifier and payload, as a CAN frame carries them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OutgoingFrame {
    pub identifier: u16,
    payload: [u8; 8],
    length: usize,
}

impl OutgoingFrame {
    pub fn of<M: Message>(message: &M) -> Self {
        let mut payload = [0; 8];
        message.write(&mut payload);
        Self {
            identifier: M::ID,
            payload,
            length: M::LENGTH,
        }
    }

    pub fn payload(&self) -> &[u8] {
        self.payload.get(..self.length).unwrap_or(&self.payload)
    }
}

/// What the companion is connected to. Commands are taken from both wires, answers and telemetry go to one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wire {
    #[default]
    Serial,
    Can,
}

#[derive(Debug, Default)]
pub struct Link {
    decoder: Decoder,
    /// Where frames go: the wire that the companion said hello on.
    active: Wire,
    /// Frames that came by the bus instead of the serial line.
    bus_frames: u16,
    /// Faulty frames on the bus.
    bus_errors: u16,
    /// Good frames that were no message for us.
    foreign: u16,
    urgent: Deque<OutgoingFrame, URGENT>,
    routine: Deque<OutgoingFrame, ROUTINE>,
    /// An answer for whoever is at the end of the other wire.
    aside: Option<(Wire, OutgoingFrame)>,
    /// Bytes of the frame that the wire has taken in part.
    staged: Staged,
    sequence: u8,
    now_us: u64,
    /// Frames dropped for want of room since the last `take_dropped`.
    dropped: u16,
}

#[derive(Debug, Default)]
struct Staged {
    bytes: [u8; MAX_FRAME],
    length: usize,
    sent: usize,
}

impl Link {
    /// Take one byte of the serial line.
    pub fn push(&mut self, byte: u8) -> Option<Frame> {
        self.decoder.push(byte)
    }

    pub fn count_bus_frame(&mut self) {
        self.bus_frames = self.bus_frames.wrapping_add(1);
    }

    pub fn count_bus_errors(&mut self, count: u16) {
        self.bus_errors = self.bus_errors.wrapping_add(count);
    }

    /// A frame of unknown identifier or wrong length.
    pub fn count_foreign(&mut self) {
        self.foreign = self.foreign.wrapping_add(1);
    }

    /// The time that a clock reply's turnaround is measured against.
    pub fn set_time(&mut self, now_us: u64) {
        self.now_us = self.now_us.max(now_us);
    }

    /// Queue an answer or an alarm.
    pub fn send_urgent<M: Message>(&mut self, message: &M) {
        let frame = OutgoingFrame::of(message);
        if self.urgent.push_back(frame).is_err() {
            self.dropped = self.dropped.saturating_add(1);
        }
    }

    /// Queue an answer ahead of everything else.
    pub fn send_first(&mut self, message: &ClockReply) {
        let frame = OutgoingFrame::of(message);
        if self.urgent.push_front(frame).is_err() {
            self.dropped = self.dropped.saturating_add(1);
        }
    }

    /// Queue telemetry.
    pub fn send_routine(&mut self, frame: OutgoingFrame) {
        if self.routine.push_back(frame).is_err() {
            self.dropped = self.dropped.saturating_add(1);
        }
    }

    /// Half of the room for telemetry is free: log lines may go out.
    pub fn has_time(&self) -> bool {
        self.routine.len() < ROUTINE / 2
    }

    /// Room for one more report among the urgent frames, with some kept for answers.
    pub fn has_urgent_room(&self) -> bool {
        self.urgent.len() < URGENT / 2
    }

    pub fn take_dropped(&mut self) -> u16 {
        core::mem::take(&mut self.dropped)
    }

    /// An answer to the end of a wire that is not the active one. One at a time: the last one counts.
    pub fn send_aside(&mut self, wire: Wire, frame: OutgoingFrame) {
        self.aside = Some((wire, frame));
    }

    /// Show life on a bus whose companion, if there is one, is connected elsewhere.
    pub fn beat(&mut self, state: &State) {
        if self.active != Wire::Can && self.aside.is_none() {
            self.send_aside(Wire::Can, OutgoingFrame::of(state));
        }
    }

    /// The wire that frames go to.
    pub fn active(&self) -> Wire {
        self.active
    }

    /// From now on frames go to this wire.
    pub fn select(&mut self, wire: Wire) {
        self.active = wire;
    }

    /// The next frame for a wire; for one that is not active only what is meant for it.
    pub fn next_frame(&mut self, wire: Wire) -> Option<OutgoingFrame> {
        if wire != self.active {
            let (_, frame) = self.aside.take_if(|(aside, _)| *aside == wire)?;
            return Some(frame);
        }
        let frame = self
            .urgent
            .pop_front()
            .or_else(|| self.routine.pop_front())?;
        if frame.identifier != ClockReply::ID {
            return Some(frame);
        }
        let mut reply = ClockReply::read(frame.payload())?;
        let turnaround = clock::low(self.now_us).wrapping_sub(reply.receive_time);
        reply.turnaround = turnaround.min(u32::from(u16::MAX)) as u16;
        Some(OutgoingFrame::of(&reply))
    }

    /// Fill `out` with bytes for the serial line; returns how many.
    pub fn transmit(&mut self, out: &mut [u8]) -> usize {
        let mut written = 0;
        for slot in out.iter_mut() {
            let Some(byte) = self.next_byte() else { break };
            *slot = byte;
            written += 1;
        }
        written
    }

    fn next_byte(&mut self) -> Option<u8> {
        if self.staged.sent >= self.staged.length {
            let frame = self.next_frame(Wire::Serial)?;
            self.staged.length = framing::encode(
                frame.identifier,
                self.sequence,
                frame.payload(),
                &mut self.staged.bytes,
            );
            self.staged.sent = 0;
            self.sequence = self.sequence.wrapping_add(1);
        }
        let byte = self.staged.bytes.get(self.staged.sent).copied();
        self.staged.sent += 1;
        byte
    }

    pub fn statistics(&self) -> LinkStatistics {
        LinkStatistics {
            frames: self.decoder.frames.wrapping_add(self.bus_frames),
            checksum_errors: self.decoder.checksum_errors.wrapping_add(self.bus_errors),
            malformed: self.decoder.malformed.wrapping_add(self.foreign),
            lost: self.decoder.lost,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rover_protocol::messages::Battery;

    fn drain(link: &mut Link, chunk: usize) -> Vec<Frame> {
        let mut decoder = Decoder::new();
        let mut frames = vec![];
        loop {
            let mut out = vec![0; chunk];
            let length = link.transmit(&mut out);
            if length == 0 {
                return frames;
            }
            frames.extend(out[..length].iter().filter_map(|byte| decoder.push(*byte)));
        }
    }

    #[test]
    fn urgent_frames_overtake_and_a_wire_may_take_any_number_of_bytes() {
        for chunk in [1, 3, 7, 64] {
            let mut link = Link::default();
            link.send_routine(OutgoingFrame::of(&Battery::default()));
            link.send_urgent(&State::default());
            let identifiers: Vec<u16> = drain(&mut link, chunk)
                .iter()
                .map(|frame| frame.identifier)
                .collect();
            assert_eq!(identifiers, [State::ID, Battery::ID]);
        }
    }

    #[test]
    fn the_turnaround_of_a_clock_reply_ends_when_its_first_byte_is_taken() {
        let mut link = Link::default();
        link.send_first(&ClockReply {
            sequence: 1,
            receive_time: u32::MAX - 99,
            turnaround: 0,
        });
        link.set_time((1 << 32) + 150);
        let reply = ClockReply::read(drain(&mut link, 4)[0].payload()).unwrap();
        assert_eq!(reply.turnaround, 250);
    }

    #[test]
    fn a_wire_that_takes_nothing_costs_frames_and_not_memory() {
        let mut link = Link::default();
        for _ in 0..100 {
            link.send_routine(OutgoingFrame::of(&Battery::default()));
        }
        assert_eq!(link.take_dropped(), 100 - ROUTINE as u16);
        assert_eq!(drain(&mut link, 64).len(), ROUTINE);
    }
}
