//! The RP2040, as on the Raspberry Pi Pico.

use embassy_rp::interrupt;
use embassy_rp::interrupt::Interrupt;
use embassy_rp::pac;
use rover_protocol::messages::{hello_build_reset_cause as cause, hello_reply_board};

use crate::tick;

/// As the handshake names it.
pub const BOARD: u8 = hello_reply_board::RP2040;
/// Bytes of flash on the board; memory-rp2040.x says the same.
pub const FLASH_SIZE: usize = 2 * 1024 * 1024;
/// The watchdog counts two for each microsecond (erratum RP2040-E1).
pub const WATCHDOG_STEPS_PER_US: u32 = 2;
/// The timer of all times here.
pub const TIMER: pac::timer::Timer = pac::TIMER;
/// Interrupt of its alarm for the control loop.
pub const CONTROL_TICK: Interrupt = Interrupt::TIMER_IRQ_1;
/// Interrupt of its alarm that comes shortly before the watchdog bites.
pub const WARNING: Interrupt = Interrupt::TIMER_IRQ_2;

#[interrupt]
unsafe fn TIMER_IRQ_1() {
    tick::on_interrupt()
}

/// Reset cause when it was not the watchdog. One bit stands for power-on and brown-out, so both read as power-on; the
/// RUN pin reads as unknown.
pub fn cold_reset_cause() -> u8 {
    let reset = pac::VREG_AND_CHIP_RESET.chip_reset().read();
    if reset.had_por() {
        cause::POWER_ON
    } else {
        cause::UNKNOWN
    }
}
