//! The driver against the chip's registers as the datasheet has them.

use embassy_futures::block_on;
use embedded_hal::i2c::{ErrorKind, ErrorType, NoAcknowledgeSource, Operation};
use embedded_hal_async::i2c::I2c;
use rover_lsm6dso::{Error, Lsm6dso, Reading};

const NOBODY: ErrorKind = ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address);

struct Chip {
    address: u8,
    registers: [u8; 128],
    pointer: usize,
    /// Answers to CTRL3_C until a reset is over.
    resetting: usize,
    /// Writes change nothing.
    stubborn: bool,
}

impl Chip {
    fn new(address: u8) -> Self {
        let mut registers = [0; 128];
        registers[0x0f] = 0x6c;
        registers[0x12] = 0x04;
        Self {
            address,
            registers,
            pointer: 0,
            resetting: 0,
            stubborn: false,
        }
    }

    fn write(&mut self, bytes: &[u8]) {
        self.pointer = usize::from(bytes[0]);
        for byte in &bytes[1..] {
            if self.pointer == 0x12 && byte & 1 != 0 {
                let identity = self.registers[0x0f];
                self.registers = Self::new(self.address).registers;
                self.registers[0x0f] = identity;
                self.resetting = 2;
            } else if !self.stubborn {
                self.registers[self.pointer] = *byte;
            }
            self.pointer += 1;
        }
    }

    fn read(&mut self, bytes: &mut [u8]) {
        for byte in bytes {
            *byte = self.registers[self.pointer];
            if self.pointer == 0x12 && self.resetting > 0 {
                self.resetting -= 1;
                *byte |= 1;
            }
            // IF_INC.
            self.pointer += usize::from(self.registers[0x12] & 4 != 0);
        }
    }
}

impl ErrorType for &mut Chip {
    type Error = ErrorKind;
}

impl I2c for &mut Chip {
    async fn transaction(
        &mut self,
        address: u8,
        operations: &mut [Operation<'_>],
    ) -> Result<(), ErrorKind> {
        if address != self.address {
            return Err(NOBODY);
        }
        for operation in operations {
            match operation {
                Operation::Write(bytes) => Chip::write(self, bytes),
                Operation::Read(bytes) => Chip::read(self, bytes),
            }
        }
        Ok(())
    }
}

#[test]
fn it_is_found_at_either_address_and_set_to_833_hz_2_g_and_250_degrees_a_second() {
    for address in [0x6a, 0x6b] {
        let mut chip = Chip::new(address);
        block_on(Lsm6dso::new(&mut chip).start()).unwrap();
        assert_eq!(chip.registers[0x10..0x13], [0x70, 0x70, 0x44]);
    }
}

#[test]
fn a_reading_is_one_burst_of_little_endian_words() {
    let mut chip = Chip::new(0x6a);
    for (at, byte) in (0x20..0x2e).zip(1_u8..) {
        chip.registers[at] = byte;
    }
    let reading = block_on(Lsm6dso::new(&mut chip).read()).unwrap();
    let expected = Reading {
        temperature: 0x0201,
        gyro: [0x0403, 0x0605, 0x0807],
        acceleration: [0x0a09, 0x0c0b, 0x0e0d],
    };
    assert_eq!(reading, expected);
}

#[test]
fn nobody_a_stranger_and_one_that_keeps_nothing_are_told_apart() {
    let mut chip = Chip::new(0x50);
    assert_eq!(
        block_on(Lsm6dso::new(&mut chip).start()),
        Err(Error::Bus(NOBODY))
    );
    let mut chip = Chip::new(0x6b);
    chip.registers[0x0f] = 0x68;
    assert_eq!(
        block_on(Lsm6dso::new(&mut chip).start()),
        Err(Error::Stranger(0x68))
    );
    let mut chip = Chip::new(0x6a);
    chip.stubborn = true;
    assert_eq!(
        block_on(Lsm6dso::new(&mut chip).start()),
        Err(Error::Stubborn)
    );
}
