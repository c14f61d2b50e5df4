//! Why the chip started, and what happens when the program cannot go on.

use core::panic::PanicInfo;

use embassy_rp::watchdog::{ResetReason, Watchdog};
use embassy_rp::{pac, rom_data};
use rover_protocol::messages::hello_build_reset_cause as cause;

use crate::{chip, emergency};

/// Reset cause as `HelloBuild` reports it.
pub fn cause(watchdog: &Watchdog) -> u8 {
    match watchdog.reset_reason() {
        Some(ResetReason::TimedOut) => cause::WATCHDOG,
        Some(ResetReason::Forced) => cause::SOFTWARE,
        None => chip::cold_reset_cause(),
    }
}

/// Start again, as a forced reset of the watchdog, so that the next start knows.
pub fn restart() -> ! {
    pac::WATCHDOG.ctrl().modify(|w| w.set_trigger(true));
    halt()
}

/// Start into the boot loader, which shows itself as a USB drive.
pub fn bootloader() -> ! {
    rom_data::reset_to_usb_boot(0, 0);
    halt()
}

/// Put the H-bridge to sleep, then wait for the watchdog.
fn halt() -> ! {
    cortex_m::interrupt::disable();
    emergency::cut();
    loop {
        cortex_m::asm::nop();
    }
}

#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    halt()
}

#[cortex_m_rt::exception]
unsafe fn HardFault(_: &cortex_m_rt::ExceptionFrame) -> ! {
    halt()
}
