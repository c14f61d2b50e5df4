//! A CAN bus of two nodes at 500 kbit/s in virtual time: both directions share it, the lowest waiting identifier goes first,
//! and a frame arrives when its last bit has passed.

use std::collections::VecDeque;

use crate::can_frame::CanFrame;

const NANOSECONDS_PER_BIT: u64 = 2_000;
/// Frames that a node keeps waiting; more are refused and counted.
const WAITING: usize = 64;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Node {
    Host,
    Rover,
}

/// A frame that has arrived at the other node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Arrival {
    pub from: Node,
    pub frame: CanFrame,
    pub time_us: u64,
}

/// What has gone over the bus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    pub frames: u64,
    pub bits: u64,
    /// Frames for which a node had no room.
    pub refused: u64,
}

#[derive(Debug, Default)]
pub struct CanBus {
    waiting: VecDeque<(Node, CanFrame)>,
    /// On the wire, and when its last bit has passed.
    passing: Option<(Node, CanFrame, u64)>,
    now_ns: u64,
    counters: Counters,
}

impl CanBus {
    /// Hand a frame to a node's controller; false when it has no room.
    pub fn offer(&mut self, from: Node, frame: CanFrame) -> bool {
        let room = self.waiting(from) < WAITING;
        if room {
            self.waiting.push_back((from, frame));
        } else {
            self.counters.refused += 1;
        }
        room
    }

    /// Frames of a node that wait for the bus.
    pub fn waiting(&self, node: Node) -> usize {
        self.waiting
            .iter()
            .filter(|(from, _)| *from == node)
            .count()
    }

    /// What has gone over the bus since the start.
    pub fn counters(&self) -> Counters {
        self.counters
    }

    /// Forget what a node has waiting.
    pub fn clear(&mut self, node: Node) {
        self.waiting.retain(|(from, _)| *from != node);
    }

    /// Let the bus run until `until_us`; without `acknowledged` nothing new gets through, as nobody is there to hear it.
    pub fn advance(&mut self, until_us: u64, acknowledged: bool) -> Vec<Arrival> {
        let until_ns = until_us * 1000;
        let mut arrivals = vec![];
        loop {
            if self.passing.is_none() && acknowledged {
                self.passing = self.next();
            }
            match self.passing {
                Some((from, frame, end_ns)) if end_ns <= until_ns => {
                    self.passing = None;
                    self.now_ns = end_ns;
                    arrivals.push(Arrival {
                        from,
                        frame,
                        time_us: end_ns / 1000,
                    });
                }
                Some(_) => break,
                None => {
                    self.now_ns = self.now_ns.max(until_ns);
                    break;
                }
            }
        }
        arrivals
    }

    /// Arbitration: the lowest identifier, of equal ones the one that waits longest.
    fn next(&mut self) -> Option<(Node, CanFrame, u64)> {
        let identifiers = self.waiting.iter().map(|(_, frame)| frame.identifier);
        let (place, _) = identifiers.enumerate().min_by_key(|(_, id)| *id)?;
        let (from, frame) = self.waiting.remove(place)?;
        let bits = u64::from(frame.bits());
        self.counters.frames += 1;
        self.counters.bits += bits;
        Some((from, frame, self.now_ns + bits * NANOSECONDS_PER_BIT))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(identifier: u16) -> CanFrame {
        CanFrame::new(identifier, &[0x55; 8])
    }

    #[test]
    fn both_directions_share_the_bus_and_the_lowest_identifier_goes_first() {
        let mut bus = CanBus::default();
        bus.advance(1_000, true);
        bus.offer(Node::Rover, frame(0x80));
        bus.offer(Node::Host, frame(0x40));
        bus.offer(Node::Rover, frame(0x70));
        bus.offer(Node::Host, frame(0x40));
        let arrivals = bus.advance(3_000, true);
        let order: Vec<(Node, u16)> = arrivals
            .iter()
            .map(|arrival| (arrival.from, arrival.frame.identifier))
            .collect();
        assert_eq!(
            order,
            [
                (Node::Host, 0x40),
                (Node::Host, 0x40),
                (Node::Rover, 0x70),
                (Node::Rover, 0x80)
            ]
        );
        // 111 bits and some stuff bits at 2 us, one after the other.
        let times: Vec<u64> = arrivals.iter().map(|arrival| arrival.time_us).collect();
        assert!((1_222..=1_270).contains(&times[0]), "{times:?}");
        assert!(times.windows(2).all(|pair| pair[1] - pair[0] >= 222));
    }

    #[test]
    fn a_frame_that_has_begun_is_not_overtaken_and_none_arrives_before_its_end() {
        let mut bus = CanBus::default();
        bus.offer(Node::Rover, frame(0x80));
        assert_eq!(bus.advance(100, true), []);
        bus.offer(Node::Host, frame(0x08));
        let arrivals = bus.advance(1_000, true);
        assert_eq!(arrivals[0].frame.identifier, 0x80);
        assert_eq!(arrivals[1].frame.identifier, 0x08);
        assert!(arrivals[0].time_us > 200);
        assert!(arrivals[1].time_us > 400);
    }

    #[test]
    fn a_full_bus_carries_some_four_frames_a_millisecond_and_refuses_the_rest() {
        let mut bus = CanBus::default();
        let mut arrived = 0;
        for ms in 1..=1_000 {
            while bus.offer(Node::Host, frame(0x40)) {}
            arrived += bus.advance(ms * 1_000, true).len();
        }
        assert!((3_700..=4_500).contains(&arrived), "{arrived}");
        assert_eq!(bus.counters().refused, 1_000);
        assert!(bus.counters().bits <= 500_000 + 130);
    }

    #[test]
    fn nothing_arrives_where_nobody_acknowledges() {
        let mut bus = CanBus::default();
        bus.offer(Node::Rover, frame(0x60));
        assert_eq!(bus.advance(10_000, false), []);
        assert_eq!(bus.advance(11_000, true).len(), 1);
    }
}
