//! Why the chip started, and what happens when the program cannot go on.

use core::panic::PanicInfo;

use embassy_rp::watchdog::{ResetReason, Watchdog};
use embassy_rp::{pac, rom_data};
use rover_protocol::messages::{
    crash_cause_cause as crash_cause, hello_build_reset_cause as cause,
};

use crate::{chip, crash, emergency};

/// Scratch register of the watchdog that tells whose time-out it was; the boot ROM leaves this one alone.
const OWNER: usize = 0;
const OURS: u32 = 0x726f_7672;

/// Reset cause as `HelloBuild` reports it.
///
/// The boot loader starts what it has written by a time-out of the watchdog as well: that is no fault, and reads as
/// software.
pub fn cause(watchdog: &mut Watchdog) -> u8 {
    let ours = watchdog.get_scratch(OWNER) == OURS;
    watchdog.set_scratch(OWNER, 0);
    match watchdog.reset_reason() {
        Some(ResetReason::TimedOut) if ours => cause::WATCHDOG,
        Some(_) => cause::SOFTWARE,
        None => chip::cold_reset_cause(),
    }
}

/// From now on a time-out is a fault of this program.
pub fn own(watchdog: &mut Watchdog) {
    watchdog.set_scratch(OWNER, OURS);
}

/// Start again, as a forced reset of the watchdog, so that the next start knows.
pub fn restart() -> ! {
    pac::WATCHDOG.ctrl().modify(|w| w.set_trigger(true));
    halt()
}

/// Start into the boot loader, which shows itself as a USB drive.
pub fn bootloader() -> ! {
    pac::WATCHDOG.scratch0().write_value(0);
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
fn panic(info: &PanicInfo) -> ! {
    let (line, place) = info.location().map_or((0, 0), |at| {
        (at.line() as u16, core::ptr::from_ref(at) as u32)
    });
    crash::die(crash_cause::PANIC, line, place);
    halt()
}

#[cortex_m_rt::exception]
unsafe fn HardFault(frame: &cortex_m_rt::ExceptionFrame) -> ! {
    crash::die(crash_cause::HARD_FAULT, 0, frame.pc());
    halt()
}
