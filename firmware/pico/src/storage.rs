//! The last sectors of the flash, as the core's parameter pages.
//!
//! While a sector is erased or written the chip cannot run from flash, so interrupts are off for that long: the core
//! asks for it only with the motors off.

use embassy_rp::flash::{Blocking, Flash as Chip, ERASE_SIZE};
use embassy_rp::peripherals::FLASH;
use embassy_rp::Peri;
use rover_core::storage::{Flash, FlashError, BLOCK};

use crate::chip::FLASH_SIZE;

/// The linker script of the chip keeps the linker out of what follows.
const START: u32 = (FLASH_SIZE - 16 * 1024) as u32;

/// Two sectors for parameters, and one for the record of a crash.
pub struct ParameterFlash(Chip<'static, FLASH, Blocking, FLASH_SIZE>);

impl ParameterFlash {
    pub fn new(flash: Peri<'static, FLASH>) -> Self {
        Self(Chip::new_blocking(flash))
    }
}

fn address(page: usize) -> u32 {
    START + (page * ERASE_SIZE) as u32
}

impl Flash for ParameterFlash {
    fn erase(&mut self, page: usize) -> Result<(), FlashError> {
        let from = address(page);
        self.0
            .blocking_erase(from, from + ERASE_SIZE as u32)
            .map_err(|_| FlashError)
    }

    fn program(&mut self, page: usize, block: &[u8; BLOCK]) -> Result<(), FlashError> {
        self.0
            .blocking_write(address(page), block)
            .map_err(|_| FlashError)
    }

    fn read(&mut self, page: usize, block: &mut [u8; BLOCK]) -> Result<(), FlashError> {
        self.0
            .blocking_read(address(page), block)
            .map_err(|_| FlashError)
    }
}
