//! Three wires and one core: what comes in on each, and which of them is spoken on.
//!
//! UART and USB carry the same bytes. Each hands over whole frames, so that bytes of two wires never mix in the core's
//! decoder. The core itself keeps serial line and CAN bus apart; which of UART and USB is the serial line is decided
//! here: the one on which the last Hello came while the motors were off, and before any Hello the UART. While they are on
//! the other one is heard only when it wants the rover to stop.

use rover_core::Core;
use rover_protocol::framing::{Decoder, MAX_FRAME};
use rover_protocol::messages::{Disarm, EmergencyStop, Hello, Stop};
use rover_protocol::Message;

use crate::chunk::Chunk;
use crate::uart::{Uart, BYTE_US};
use crate::{can, can_report, uart, usb};

/// Bytes of one wire up to the zero that ends a frame.
#[derive(Default)]
struct Collector {
    bytes: [u8; MAX_FRAME],
    length: usize,
}

impl Collector {
    /// The bytes of a frame when `byte` ends it, and of what is longer than any frame.
    fn push(&mut self, byte: u8) -> Option<&[u8]> {
        if let Some(slot) = self.bytes.get_mut(self.length) {
            *slot = byte;
            self.length += 1;
        }
        if byte != 0 && self.length < MAX_FRAME {
            return None;
        }
        let length = core::mem::take(&mut self.length);
        self.bytes.get(..length)
    }
}

/// Whether these bytes are a good Hello. All others are told from it by three bytes: its identifier is 0x0100.
fn is_hello(frame: &[u8]) -> bool {
    let [1, _, 1, ..] = frame else { return false };
    let mut decoder = Decoder::new();
    let decoded = frame.iter().find_map(|byte| decoder.push(*byte));
    decoded.is_some_and(|frame| frame.identifier == Hello::ID)
}

/// Whether these bytes want the rover to stop: identifiers below 256 are a run of one byte before a zero.
fn is_stop(frame: &[u8]) -> bool {
    let [2, low, ..] = frame else { return false };
    [EmergencyStop::ID, Stop::ID, Disarm::ID].contains(&u16::from(*low))
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Serial {
    Uart,
    Usb,
}

/// All of them.
pub struct Link {
    uart: Uart,
    from_uart: Collector,
    from_usb: Collector,
    serial: Serial,
}

impl Link {
    pub fn new(uart: Uart) -> Self {
        Self {
            uart,
            from_uart: Collector::default(),
            from_usb: Collector::default(),
            serial: Serial::Uart,
        }
    }

    /// Everything that has come in. `powered`: the motors are on, so that the serial line stays where it is.
    pub fn receive(&mut self, core: &mut Core, powered: bool) {
        if uart::LOST.take() | can::LOST.take() {
            core.note_receive_overflow();
        }
        can_report::deliver(core);
        while let Ok(chunk) = uart::RECEIVED.try_receive() {
            let collector = &mut self.from_uart;
            let heard = !powered || self.serial == Serial::Uart;
            // The last byte came at the chunk's time, the others before it, one after the other.
            if feed(core, collector, &chunk, BYTE_US, heard) && !powered {
                self.serial = Serial::Uart;
            }
        }
        while let Ok(chunk) = usb::RECEIVED.try_receive() {
            let heard = !powered || self.serial == Serial::Usb;
            if feed(core, &mut self.from_usb, &chunk, 0, heard) && !powered {
                self.serial = Serial::Usb;
            }
        }
        while let Ok(received) = can::RECEIVED.try_receive() {
            let frame = &received.frame;
            core.receive_frame(frame.identifier(), frame.payload(), received.time_us);
        }
    }

    /// What the core has to say, as much as each wire takes now: what waits there can still be overtaken.
    pub fn transmit(&mut self, core: &mut Core) {
        match self.serial {
            Serial::Uart => self.uart.send(core),
            Serial::Usb => usb::send(core),
        }
        can::send(core);
    }

    /// Both directions of the line that is always there can be served.
    pub fn is_alive(&self) -> bool {
        self.uart.is_listening()
    }
}

/// Give the frames in a chunk to the core, only those that stop the rover unless it is `heard`; true when one was a
/// Hello.
fn feed(
    core: &mut Core,
    collector: &mut Collector,
    chunk: &Chunk,
    byte_us: u64,
    heard: bool,
) -> bool {
    let mut greeted = false;
    let mut behind_us = byte_us * chunk.bytes().len() as u64;
    for byte in chunk.bytes() {
        behind_us = behind_us.saturating_sub(byte_us);
        if let Some(frame) = collector.push(*byte) {
            if !heard && !is_stop(frame) {
                continue;
            }
            core.receive(frame, chunk.time_us.saturating_sub(behind_us));
            if is_hello(frame) {
                greeted = true;
                can_report::greet(core);
            }
        }
    }
    greeted
}
