//! The serial link: bytes from the UART to the control loop with their time, and back.

use core::sync::atomic::{AtomicBool, Ordering};

use embassy_executor::task;
use embassy_rp::bind_interrupts;
use embassy_rp::pac;
use embassy_rp::peripherals::UART0;
use embassy_rp::uart::{
    BufferedInterruptHandler, BufferedUart, BufferedUartRx, BufferedUartTx, Config, Error,
};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use embassy_sync::pipe::Pipe;
use embassy_time::{with_timeout, Instant};
use embedded_io_async::{Read, Write};
use static_cell::StaticCell;

use crate::life;
use crate::pins::{LinkPins, BAUD};

bind_interrupts!(struct Irqs {
    UART0_IRQ => BufferedInterruptHandler<UART0>;
});

/// Bytes that came in together, and when.
pub struct Chunk {
    pub time_us: u64,
    pub bytes: [u8; Self::SIZE],
    pub length: usize,
}

impl Chunk {
    /// As many as arrive in one tick of the control loop.
    const SIZE: usize = 24;

    pub fn bytes(&self) -> &[u8] {
        self.bytes.get(..self.length).unwrap_or(&self.bytes)
    }
}

/// To the control loop, which empties it in each tick.
pub static RECEIVED: Channel<CriticalSectionRawMutex, Chunk, 8> = Channel::new();
/// From the control loop. Short, so that what is queued is decided in the core and not hidden here: 5.6 ms at most.
pub static OUTGOING: Pipe<CriticalSectionRawMutex, 128> = Pipe::new();

/// Bytes were lost because nobody took them in time.
static OVERRUN: AtomicBool = AtomicBool::new(false);

/// Whether that has happened since the last call.
pub fn take_overrun() -> bool {
    let overrun = OVERRUN.load(Ordering::Relaxed);
    if overrun {
        OVERRUN.store(false, Ordering::Relaxed);
    }
    overrun
}

/// Queue bytes, at most [`Pipe::free_capacity`] of [`OUTGOING`].
pub fn queue(mut bytes: &[u8]) {
    // The pipe takes only what fits in front of its wrap, so it may need two writes.
    while let Ok(taken) = OUTGOING.try_write(bytes) {
        match bytes.get(taken..) {
            Some(rest) if taken > 0 => bytes = rest,
            _ => return,
        }
    }
}

/// Open the port.
pub fn open(pins: LinkPins) -> (BufferedUartTx, BufferedUartRx) {
    static TX: StaticCell<[u8; 32]> = StaticCell::new();
    static RX: StaticCell<[u8; 256]> = StaticCell::new();
    let mut config = Config::default();
    config.baudrate = BAUD;
    let uart = BufferedUart::new(
        pins.uart,
        pins.tx,
        pins.rx,
        Irqs,
        TX.init([0; 32]),
        RX.init([0; 256]),
        config,
    );
    // Interrupt at 4 bytes instead of 28: what is fewer waits 32 bit times (139 us) for its time stamp.
    pac::UART0.uartifls().modify(|w| w.set_rxiflsel(0));
    uart.split()
}

#[task]
pub async fn receive(mut uart: BufferedUartRx) {
    loop {
        life::RECEIVE.show();
        let mut bytes = [0; Chunk::SIZE];
        match with_timeout(life::IDLE, uart.read(&mut bytes)).await {
            Ok(Ok(length)) => {
                let time_us = Instant::now().as_micros();
                RECEIVED
                    .send(Chunk {
                        time_us,
                        bytes,
                        length,
                    })
                    .await;
            }
            Ok(Err(Error::Overrun)) => OVERRUN.store(true, Ordering::Relaxed),
            // Another line error costs the bytes that it hit; their frame fails its checksum and is counted there.
            Ok(Err(_)) | Err(_) => {}
        }
    }
}

#[task]
pub async fn transmit(mut uart: BufferedUartTx) {
    let mut bytes = [0; 32];
    loop {
        life::TRANSMIT.show();
        if let Ok(length) = with_timeout(life::IDLE, OUTGOING.read(&mut bytes)).await {
            if let Some(sent) = bytes.get(..length) {
                let Ok(()) = uart.write_all(sent).await else {
                    continue;
                };
            }
        }
    }
}
