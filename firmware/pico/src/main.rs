//! The rover's microcontroller, an RP2040 or RP2350: pins and peripherals around `rover_core`, and nothing else.
//!
//! Three levels, each preempting the next: interrupts with the edges of sonars and emergency stop, the control loop at 1 kHz
//! (`control`), and the thread executor with CAN, USB and the watchdog. The core belongs to the control loop alone;
//! everything else reaches it through queues, so there are no locks.

#![no_std]
#![no_main]

#[cfg(feature = "rp2040")]
mod arithmetic;
mod battery;
mod bridge;
mod can;
mod can_report;
mod chip;
mod chunk;
mod control;
mod crash;
mod emergency;
mod encoders;
mod inertial;
mod life;
mod link;
mod mark;
mod motors;
mod overrun;
mod pins;
mod reset;
mod sonar;
mod storage;
mod tick;
mod uart;
mod usb;

use embassy_executor::{InterruptExecutor, SpawnError, SpawnToken, Spawner};
use embassy_rp::interrupt;
use embassy_rp::interrupt::{InterruptExt, Priority};
use embassy_rp::watchdog::Watchdog;
use rover_core::Core;
use static_cell::StaticCell;

static EDGES: InterruptExecutor = InterruptExecutor::new();
static CONTROL: InterruptExecutor = InterruptExecutor::new();

#[interrupt]
unsafe fn SWI_IRQ_0() {
    EDGES.on_interrupt()
}

#[interrupt]
unsafe fn SWI_IRQ_1() {
    CONTROL.on_interrupt()
}

/// A task is spawned once, at the start, so there is always room for it.
fn once<S>(token: Result<SpawnToken<S>, SpawnError>) -> SpawnToken<S> {
    match token {
        Ok(token) => token,
        Err(_) => unreachable!("task spawned twice"),
    }
}

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let board = pins::Board::new(embassy_rp::init(Default::default()));
    let mut watchdog = Watchdog::new(board.watchdog);
    let reset_cause = reset::cause(&mut watchdog);
    let crashed = crash::begin(reset_cause);
    let identity = mark::identity(reset_cause);

    usb::start(board.usb, spawner);
    spawner.spawn(once(can::run(board.can)));
    spawner.spawn(once(inertial::run(board.inertial)));

    // The timer's first alarm and the UART stay at P0.
    interrupt::IO_IRQ_BANK0.set_priority(Priority::P1);
    interrupt::SWI_IRQ_0.set_priority(Priority::P1);
    let edges = EDGES.start(interrupt::SWI_IRQ_0);
    edges.spawn(once(emergency::run(board.emergency_stop)));
    edges.spawn(once(sonar::run(board.sonars)));

    static CORE: StaticCell<Core> = StaticCell::new();
    let core = CORE.init(Core::new(identity));
    let mut flash = storage::ParameterFlash::new(board.flash);
    core.attach_storage(&mut flash);
    if let Some(record) = crashed {
        core.keep_crash(record, &mut flash);
    }
    let hardware = control::Hardware {
        link: link::Link::new(uart::Uart::new(board.link)),
        battery: battery::Battery::new(board.battery),
        encoders: encoders::Encoders::new(board.encoders),
        motors: motors::Motors::new(board.motors),
        panel: board.panel,
        bumper: board.bumper,
        flash,
    };
    interrupt::SWI_IRQ_1.set_priority(Priority::P2);
    chip::CONTROL_TICK.set_priority(Priority::P2);
    // SAFETY: its handler needs nothing that is not there yet.
    unsafe { chip::CONTROL_TICK.enable() };
    CONTROL
        .start(interrupt::SWI_IRQ_1)
        .spawn(once(control::run(core, hardware)));

    spawner.spawn(once(life::run(watchdog)));
}
