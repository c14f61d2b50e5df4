//! The UART: its interrupt only receives, the control loop fills its transmit FIFO once a millisecond.
//!
//! That is one interrupt for 16 bytes or for the end of a burst, and none at all for sending: the FIFO of 32 bytes gets as
//! many as the line takes in a millisecond (23). It has just run dry when the next ones come, and all that waits longer
//! can still be overtaken by what is urgent.

use embassy_rp::interrupt;
use embassy_rp::interrupt::InterruptExt;
use embassy_rp::pac;
use embassy_rp::uart::{Blocking, Config, Uart as Port};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use embassy_time::Instant;
use rover_core::Core;

use crate::chunk::Chunk;
use crate::overrun::Overrun;
use crate::pins::{LinkPins, BAUD};

/// What the line takes from one tick to the next, whole bytes.
const BYTES_PER_TICK: u32 = BAUD / 10_000;
/// Time of one byte on the line, with its start and stop bit.
pub const BYTE_US: u64 = 10_000_000 / BAUD as u64;
/// The receive timeout comes so long after the last byte (PL011: 32 bits).
const SILENCE_US: u64 = 32_000_000 / BAUD as u64;
/// Receive interrupt at 16 bytes: they come in 0.7 ms, and 16 more fit before one is lost.
const HALF_FULL: u8 = 2;
/// Bits of UARTDR beside the byte: overrun, and faults of this byte.
const OVERRUN: u32 = 1 << 11;
const FAULTY: u32 = 0x7 << 8;

/// To the control loop, which empties it in each tick.
pub static RECEIVED: Channel<CriticalSectionRawMutex, Chunk, 8> = Channel::new();
/// Bytes were lost because nobody took them in time.
pub static LOST: Overrun = Overrun::new();

/// The open port.
pub struct Uart {
    _port: Port<'static, Blocking>,
}

impl Uart {
    pub fn new(pins: LinkPins) -> Self {
        let mut config = Config::default();
        config.baudrate = BAUD;
        let port = Port::new_blocking(pins.uart, pins.tx, pins.rx, config);
        pac::UART0.uartifls().modify(|w| w.set_rxiflsel(HALF_FULL));
        pac::UART0.uartimsc().write(|w| {
            w.set_rxim(true);
            w.set_rtim(true);
        });
        // SAFETY: the handler below needs nothing that is not there yet.
        unsafe { interrupt::UART0_IRQ.enable() };
        Self { _port: port }
    }

    /// As many bytes of the core as leave until the next tick.
    pub fn send(&mut self, core: &mut Core) {
        let mut byte = [0];
        for _ in 0..BYTES_PER_TICK {
            if pac::UART0.uartfr().read().txff() || core.transmit(&mut byte) == 0 {
                return;
            }
            let [byte] = byte;
            pac::UART0.uartdr().write(|w| w.set_data(byte));
        }
    }

    /// The port is on and would tell of bytes that come in.
    pub fn is_listening(&self) -> bool {
        let mask = pac::UART0.uartimsc().read();
        pac::UART0.uartcr().read().uarten() && mask.rxim() && mask.rtim()
    }
}

#[embassy_rp::interrupt]
fn UART0_IRQ() {
    let now_us = Instant::now().as_micros();
    let port = pac::UART0;
    let time_us = if port.uartmis().read().rtmis() {
        now_us.saturating_sub(SILENCE_US)
    } else {
        now_us
    };
    port.uarticr().write(|w| w.set_rtic(true));
    loop {
        let mut chunk = Chunk::new(time_us);
        while chunk.has_room() && !port.uartfr().read().rxfe() {
            let data = port.uartdr().read();
            if data.0 & OVERRUN != 0 {
                LOST.note();
            }
            // A faulty byte is left out; its frame fails its checksum and is counted there.
            if data.0 & FAULTY == 0 {
                chunk.push(data.data());
            }
        }
        if chunk.bytes().is_empty() {
            return;
        }
        if RECEIVED.try_send(chunk).is_err() {
            LOST.note();
        }
    }
}
