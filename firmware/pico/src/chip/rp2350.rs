//! The RP2350A, as on the Raspberry Pi Pico 2, with its Cortex-M33 in secure mode.

use embassy_rp::interrupt;
use embassy_rp::interrupt::Interrupt;
use embassy_rp::pac;
use rover_protocol::messages::{hello_build_reset_cause as cause, hello_reply_board};

use crate::tick;

/// As the handshake names it.
pub const BOARD: u8 = hello_reply_board::RP2350;
/// Bytes of flash on the board; memory-rp2350.x says the same.
pub const FLASH_SIZE: usize = 4 * 1024 * 1024;
/// The watchdog counts microseconds.
pub const WATCHDOG_STEPS_PER_US: u32 = 1;
/// The timer of all times here.
pub const TIMER: pac::timer::Timer = pac::TIMER0;
/// Interrupt of its alarm for the control loop.
pub const CONTROL_TICK: Interrupt = Interrupt::TIMER0_IRQ_1;
/// Interrupt of its alarm that comes shortly before the watchdog bites.
pub const WARNING: Interrupt = Interrupt::TIMER0_IRQ_2;

#[interrupt]
unsafe fn TIMER0_IRQ_1() {
    tick::on_interrupt()
}

/// Reset cause when it was not the watchdog (datasheet section 7.4, CHIP_RESET). A dip of the supply that the glitch
/// detector saw counts as brown-out; the RUN pin and the debugger read as unknown.
pub fn cold_reset_cause() -> u8 {
    let reset = pac::POWMAN.chip_reset().read();
    if reset.had_bor() || reset.had_glitch_detect() {
        cause::BROWN_OUT
    } else if reset.had_por() {
        cause::POWER_ON
    } else {
        cause::UNKNOWN
    }
}
