//! Three wires and one core: what comes in on each, and which of them is spoken on.
//!
//! UART and USB carry the same bytes. Each hands over whole frames, so that bytes of two wires never mix in the core's
//! decoder. The core itself keeps serial line and CAN bus apart; which of UART and USB is the serial line is decided
//! here: the one on which the last Hello came that the core takes, and before any Hello the UART.

use rover_core::Core;
use rover_protocol::framing::{Decoder, MAX_FRAME};
use rover_protocol::messages::{Hello, SCHEMA_HASH};
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

/// A Hello, if these bytes are one. All others are told from it by three bytes: its identifier is 0x0100.
fn hello(frame: &[u8]) -> Option<Hello> {
    let [1, _, 1, ..] = frame else { return None };
    let mut decoder = Decoder::new();
    let frame = frame.iter().find_map(|byte| decoder.push(*byte))?;
    if frame.identifier == Hello::ID {
        Hello::read(frame.payload())
    } else {
        None
    }
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

    /// Everything that has come in. `powered`: the motors are on, so that a companion of another version is not
    /// answered on a wire of its own.
    pub fn receive(&mut self, core: &mut Core, powered: bool) {
        if uart::LOST.take() | can::LOST.take() {
            core.note_receive_overflow();
        }
        can_report::deliver(core);
        while let Ok(chunk) = uart::RECEIVED.try_receive() {
            let collector = &mut self.from_uart;
            // The last byte came at the chunk's time, the others before it, one after the other.
            if feed(core, collector, &chunk, BYTE_US, powered) {
                self.serial = Serial::Uart;
            }
        }
        while let Ok(chunk) = usb::RECEIVED.try_receive() {
            if feed(core, &mut self.from_usb, &chunk, 0, powered) {
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

/// Give the frames in a chunk to the core; true when one was a Hello that makes this wire the serial line.
fn feed(
    core: &mut Core,
    collector: &mut Collector,
    chunk: &Chunk,
    byte_us: u64,
    powered: bool,
) -> bool {
    let mut chosen = false;
    let mut behind_us = byte_us * chunk.bytes().len() as u64;
    for byte in chunk.bytes() {
        behind_us = behind_us.saturating_sub(byte_us);
        if let Some(frame) = collector.push(*byte) {
            let greeting = hello(frame);
            if let Some(hello) = &greeting {
                chosen |= !powered || hello.schema_hash == SCHEMA_HASH;
            }
            core.receive(frame, chunk.time_us.saturating_sub(behind_us));
            if greeting.is_some() {
                can_report::greet(core);
            }
        }
    }
    chosen
}
