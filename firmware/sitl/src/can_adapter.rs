//! The CAN wire: a serial CAN adapter on the host's line, a bus, and the core's controller on its other end.
//!
//! All goes in ticks, in the same ones as on the emulated board (hil_tests/rover_hil/emulator/paced_adapter.py): two
//! frames a millisecond go on the bus from either side, which carries them within it; what arrives reaches the core before
//! the tick that ends the millisecond, each with the time of its last bit.

use std::collections::VecDeque;
use std::os::fd::AsFd;

use rover_core::Core;

use crate::can_bus::{Arrival, CanBus, Counters, Node};
use crate::can_frame::CanFrame;
use crate::line::Line;
use crate::serial::Meter;
use crate::slcan::{self, Command};

/// Frames that the rover's driver takes from the core ahead of the bus; more would hide urgent ones in it.
const DRIVER_QUEUE: usize = 8;
/// From either node, as in firmware/pico/src/can.rs: with four of them the bus is full.
const FRAMES_PER_TICK: usize = 2;
/// Ticks from the opening until the adapter sends: a board that was switched on with it listens by then.
const OPENING_TICKS: u32 = 3;
/// The board's adapter sends 60 us before a tick, and its interrupt is answered 10 us after a frame's last bit: stamps
/// are so much earlier than here.
const LEAD_US: u64 = 50;
/// Frames that the adapter holds back; more are refused.
const HELD: usize = 64;
const HALF_MEGABIT: u8 = 6;
/// Status bits of the adapter, cleared by reading.
const RECEIVE_FULL: u8 = 1 << 0;
const TRANSMIT_FULL: u8 = 1 << 1;

pub struct CanAdapter {
    line: Line,
    host: Host,
    bus: CanBus,
    /// The rover's UART, to which nothing is connected.
    unused: Meter,
}

/// The adapter's side of the line to the host.
#[derive(Default)]
struct Host {
    open: bool,
    opening: u32,
    held: VecDeque<CanFrame>,
    text: Vec<u8>,
    /// The line is longer than any command: ignore it.
    overlong: bool,
    flags: u8,
    answers: Vec<u8>,
}

impl CanAdapter {
    pub fn new(line: Line, unused_baud: u32) -> Self {
        Self {
            line,
            host: Host::default(),
            bus: CanBus::default(),
            unused: Meter::new(unused_baud),
        }
    }

    pub fn bytes_sent(&self) -> u64 {
        self.line.bytes_sent()
    }

    /// What has gone over the bus since the start.
    pub fn counters(&self) -> Counters {
        self.bus.counters()
    }

    /// Let the bus run until `now_us`, feed the core what has arrived, then take the host's new lines.
    pub fn receive(&mut self, core: &mut Core, due: u64, now_us: u64, ticks: &impl AsFd) -> bool {
        let mut heard = vec![];
        for arrival in self.bus.advance(now_us, self.host.open) {
            let Arrival {
                from,
                frame,
                time_us,
            } = arrival;
            match from {
                Node::Host => {
                    let stamp_us = time_us.saturating_sub(LEAD_US);
                    core.receive_frame(frame.identifier, frame.payload(), stamp_us);
                }
                Node::Rover => heard.push(frame),
            }
        }
        // The order in which the board's controller happened to get them is not told.
        heard.sort_by_key(|frame| frame.identifier);
        for frame in &heard {
            self.host.tell(frame, self.line.room());
        }
        let (host, bus) = (&mut self.host, &mut self.bus);
        let going_on = self.line.receive(due, ticks, |bytes| {
            bytes.iter().for_each(|byte| host.push(*byte, bus));
        });
        self.host.release(&mut self.bus);
        going_on
    }

    /// Hand the core's frames to the bus and what the adapter has to say to the host.
    pub fn transmit(&mut self, core: &mut Core, now_us: u64) {
        self.unused.take(core, now_us, &mut [0; 256]);
        for _ in 0..FRAMES_PER_TICK {
            if self.bus.waiting(Node::Rover) >= DRIVER_QUEUE {
                break;
            }
            let Some(frame) = core.transmit_frame() else {
                break;
            };
            let frame = CanFrame::new(frame.identifier, frame.payload());
            self.bus.offer(Node::Rover, frame);
        }
        let fits = self.host.answers.len().min(self.line.room());
        self.line.send(&self.host.answers[..fits]);
        self.host.answers.clear();
    }
}

impl Host {
    /// Take one byte of the line.
    fn push(&mut self, byte: u8, bus: &mut CanBus) {
        if byte != slcan::END {
            self.overlong |= self.text.len() >= slcan::LONGEST;
            if !self.overlong {
                self.text.push(byte);
            }
            return;
        }
        let command = match self.overlong {
            true => Command::Unknown,
            false => slcan::parse(&self.text),
        };
        self.text.clear();
        self.overlong = false;
        self.execute(command, bus);
    }

    /// Once a tick: what has come first goes on the bus.
    fn release(&mut self, bus: &mut CanBus) {
        if self.opening > 0 {
            self.opening -= 1;
            return;
        }
        while bus.waiting(Node::Host) < FRAMES_PER_TICK {
            let Some(frame) = self.held.pop_front() else {
                return;
            };
            bus.offer(Node::Host, frame);
        }
    }

    /// Frames that are taken are not answered: python-can would read the empty answer as "no message".
    fn execute(&mut self, command: Command, bus: &mut CanBus) {
        let answer: &[u8] = match command {
            Command::Nothing => &[],
            Command::Transmit(_) | Command::Foreign if !self.open => &[slcan::REFUSED],
            Command::Foreign => &[],
            Command::Transmit(frame) => {
                if self.held.len() < HELD {
                    self.held.push_back(frame);
                    &[]
                } else {
                    self.flags |= TRANSMIT_FULL;
                    &[slcan::REFUSED]
                }
            }
            Command::Open => {
                self.open = true;
                self.opening = OPENING_TICKS;
                b"\r"
            }
            Command::Close => {
                self.open = false;
                self.held.clear();
                bus.clear(Node::Host);
                b"\r"
            }
            Command::Bitrate(HALF_MEGABIT) | Command::Setting => b"\r",
            // The bus runs at 500 kbit/s: a node of another speed would only disturb it.
            Command::Bitrate(_) | Command::Unknown => &[slcan::REFUSED],
            Command::Version => b"V0101\r",
            Command::SerialNumber => b"NROVR\r",
            Command::Flags => {
                let flags = std::mem::take(&mut self.flags);
                self.answers.extend(format!("F{flags:02X}\r").bytes());
                &[]
            }
        };
        self.answers.extend_from_slice(answer);
    }

    /// A frame for the host; lost when its line has no room for it.
    fn tell(&mut self, frame: &CanFrame, room: usize) {
        let line = slcan::line(frame);
        if self.answers.len() + line.len() > room {
            self.flags |= RECEIVE_FULL;
        } else {
            self.answers.extend(line.bytes());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Frames that each of so many ticks puts on an idle bus when `lines` came with the first.
    fn released(lines: &[u8], ticks: usize) -> Vec<usize> {
        let (mut host, mut bus) = (Host::default(), CanBus::default());
        lines.iter().for_each(|byte| host.push(*byte, &mut bus));
        (1..=ticks as u64)
            .map(|tick| {
                host.release(&mut bus);
                bus.advance(tick * 1_000, true).len()
            })
            .collect()
    }

    #[test]
    fn the_host_sends_two_frames_a_tick_from_the_fourth_tick_on() {
        assert_eq!(released(b"O\rt0100\rt0200\rt0300\r", 6), [0, 0, 0, 2, 1, 0]);
    }

    #[test]
    fn what_is_held_when_the_host_closes_never_leaves() {
        assert_eq!(released(b"O\rt0100\rC\rO\rt0200\r", 5), [0, 0, 0, 1, 0]);
    }
}
