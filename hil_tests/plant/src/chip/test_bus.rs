//! Memory alone, for tests of the processor: 4 KiB from address 0, with the vectors at its beginning.

use super::core::{Bus, Core, Fault};

/// Where the tests' programs begin.
pub const CODE: u32 = 0x200;
/// Where their exception handlers do.
pub const HANDLER: u32 = 0x400;
/// Top of the stack.
pub const STACK: u32 = 0x1000;

/// See above.
pub struct TestBus(Vec<u8>);

impl Default for TestBus {
    fn default() -> Self {
        let mut bus = Self(vec![0; STACK as usize]);
        bus.word(0, STACK);
        bus.word(4, CODE | 1);
        bus
    }
}

impl TestBus {
    /// Puts a word there.
    pub fn word(&mut self, address: u32, value: u32) {
        self.store(address, 4, value).unwrap();
    }

    /// Puts an instruction there.
    pub fn half(&mut self, address: u32, value: u16) {
        self.store(address, 2, u32::from(value)).unwrap();
    }

    /// The word that stands there.
    pub fn read_word(&self, address: u32) -> u32 {
        let at = address as usize;
        u32::from_le_bytes(self.0[at..at + 4].try_into().unwrap())
    }
}

impl Bus for TestBus {
    fn fetch(&mut self, address: u32) -> Result<u16, Fault> {
        self.load(address, 2).map(|half| half as u16)
    }

    fn load(&mut self, address: u32, size: u32) -> Result<u32, Fault> {
        if address & (size - 1) != 0 || address + size > STACK {
            return Err(Fault::Hard);
        }
        let bytes = &self.0[address as usize..(address + size) as usize];
        Ok(bytes
            .iter()
            .rev()
            .fold(0, |value, byte| value << 8 | u32::from(*byte)))
    }

    fn store(&mut self, address: u32, size: u32, value: u32) -> Result<(), Fault> {
        if address & (size - 1) != 0 || address + size > STACK {
            return Err(Fault::Hard);
        }
        for byte in 0..size {
            self.0[(address + byte) as usize] = (value >> (8 * byte)) as u8;
        }
        Ok(())
    }
}

/// A core after a reset, at [`CODE`] with its stack at [`STACK`].
pub fn booted(bus: &mut TestBus) -> Core {
    Core::reset(bus).unwrap()
}
