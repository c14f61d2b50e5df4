//! USB serial (CDC-ACM) on the board's own socket, with the same bytes as the UART.
//!
//! Its interrupt lies below the control loop and only wakes; packets are copied in the thread executor. Without a host
//! nothing here ever runs, so there is no sign of life either: if these tasks were to hang, so would those of the CAN
//! bus and the watchdog, which share their executor.

use embassy_executor::Spawner;
use embassy_rp::bind_interrupts;
use embassy_rp::interrupt;
use embassy_rp::interrupt::{InterruptExt, Priority};
use embassy_rp::peripherals::USB;
use embassy_rp::usb::{Driver, InterruptHandler};
use embassy_rp::Peri;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use embassy_sync::pipe::Pipe;
use embassy_time::Instant;
use embassy_usb::class::cdc_acm::{CdcAcmClass, Receiver, Sender, State};
use embassy_usb::{Builder, Config, UsbDevice};
use rover_core::Core;
use static_cell::StaticCell;

use crate::chunk::Chunk;
use crate::crash::{self, task};
use crate::once;

bind_interrupts!(struct Irqs {
    USBCTRL_IRQ => InterruptHandler<USB>;
});

type Port = Driver<'static, USB>;

/// Raspberry Pi, and the number that its SDK gives to any serial port of a Pico.
const VENDOR: u16 = 0x2e8a;
const PRODUCT: u16 = 0x000a;
/// Full speed.
const PACKET: u16 = 64;
/// One less than a full packet, so that none needs an empty one behind it.
const SHORT: usize = PACKET as usize - 1;

/// To the control loop, which empties it in each tick. When it is full the host has to wait, so nothing is lost.
pub static RECEIVED: Channel<CriticalSectionRawMutex, Chunk, 8> = Channel::new();
/// From the control loop. Short, so that what is queued is decided in the core and not hidden here.
static OUTGOING: Pipe<CriticalSectionRawMutex, 128> = Pipe::new();

/// As many bytes of the core as there is room for.
pub fn send(core: &mut Core) {
    let mut bytes = [0; SHORT];
    let room = OUTGOING.free_capacity().min(bytes.len());
    let Some(free) = bytes.get_mut(..room) else {
        return;
    };
    let length = core.transmit(free);
    let mut rest = free.get(..length).unwrap_or_default();
    // The pipe takes only what fits in front of its wrap, so it may need two writes.
    while let (Ok(taken), false) = (OUTGOING.try_write(rest), rest.is_empty()) {
        rest = rest.get(taken..).unwrap_or_default();
    }
}

/// Show a serial port to whatever may be at the other end.
pub fn start(usb: Peri<'static, USB>, spawner: Spawner) {
    static CONFIGURATION: StaticCell<[u8; 96]> = StaticCell::new();
    static STORE: StaticCell<[u8; 16]> = StaticCell::new();
    static CONTROL: StaticCell<[u8; 64]> = StaticCell::new();
    static STATE: StaticCell<State> = StaticCell::new();

    let driver = Driver::new(usb, Irqs);
    interrupt::USBCTRL_IRQ.set_priority(Priority::P3);
    let mut config = Config::new(VENDOR, PRODUCT);
    config.manufacturer = Some("rover");
    config.product = Some("rover firmware");
    config.max_power = 100;
    let mut builder = Builder::new(
        driver,
        config,
        CONFIGURATION.init([0; 96]),
        STORE.init([0; 16]),
        &mut [],
        CONTROL.init([0; 64]),
    );
    let class = CdcAcmClass::new(&mut builder, STATE.init(State::new()), PACKET);
    let (sender, receiver) = class.split();
    spawner.spawn(once(device(builder.build())));
    spawner.spawn(once(transmit(sender)));
    spawner.spawn(once(receive(receiver)));
}

#[embassy_executor::task]
async fn device(mut device: UsbDevice<'static, Port>) {
    crash::within(task::USB, device.run()).await
}

#[embassy_executor::task]
async fn transmit(sender: Sender<'static, Port>) {
    crash::within(task::USB, transmit_packets(sender)).await
}

async fn transmit_packets(mut sender: Sender<'static, Port>) {
    let mut bytes = [0; SHORT];
    loop {
        sender.wait_connection().await;
        loop {
            let length = OUTGOING.read(&mut bytes).await;
            let packet = bytes.get(..length).unwrap_or_default();
            if sender.write_packet(packet).await.is_err() {
                break;
            }
        }
    }
}

#[embassy_executor::task]
async fn receive(receiver: Receiver<'static, Port>) {
    crash::within(task::USB, receive_packets(receiver)).await
}

async fn receive_packets(mut receiver: Receiver<'static, Port>) {
    let mut bytes = [0; PACKET as usize];
    loop {
        receiver.wait_connection().await;
        while let Ok(length) = receiver.read_packet(&mut bytes).await {
            let time_us = Instant::now().as_micros();
            let mut chunk = Chunk::new(time_us);
            for byte in bytes.iter().take(length) {
                chunk.push(*byte);
                if !chunk.has_room() {
                    RECEIVED
                        .send(core::mem::replace(&mut chunk, Chunk::new(time_us)))
                        .await;
                }
            }
            if !chunk.bytes().is_empty() {
                RECEIVED.send(chunk).await;
            }
        }
    }
}
