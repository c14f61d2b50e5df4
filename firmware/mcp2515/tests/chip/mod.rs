//! An MCP2515 at the level of its registers, after the datasheet DS20001801: what comes over SPI, and a bus on the other
//! side that a test speaks for.

#![allow(dead_code)]

use std::cell::RefCell;
use std::convert::Infallible;
use std::future::Future;
use std::pin::pin;
use std::rc::Rc;
use std::task::{Context, Poll, Waker};

use embedded_hal_async::delay::DelayNs;
use embedded_hal_async::spi::{ErrorType, Operation, SpiDevice};

const CANSTAT: usize = 0x0e;
const CANCTRL: usize = 0x0f;
const TEC: usize = 0x1c;
const REC: usize = 0x1d;
const CANINTE: usize = 0x2b;
const CANINTF: usize = 0x2c;
const EFLG: usize = 0x2d;
const TRANSMIT: [usize; 3] = [0x30, 0x40, 0x50];
const RECEIVE: [usize; 2] = [0x60, 0x70];
const FILTERS: [usize; 6] = [0x00, 0x04, 0x08, 0x10, 0x14, 0x18];
const MASKS: [usize; 2] = [0x20, 0x24];

/// A frame on the bus: identifier and payload.
pub type OnBus = (u16, Vec<u8>);

#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Wiring {
    Sound,
    /// Not there: the input reads always this.
    Reads(u8),
    /// The receive line is held low, so it never sees the bus idle and stays in configuration mode.
    BusHeldLow,
}

pub struct Registers {
    pub memory: [u8; 128],
    pub wiring: Wiring,
    /// Everything that was written to a transmit buffer that was waiting, and every other thing that the datasheet forbids.
    pub offences: Vec<String>,
    pub transactions: usize,
    /// Resets answered with no oscillator yet.
    pub oscillator_starts_after: usize,
}

/// Both ends hold it.
#[derive(Clone)]
pub struct Chip(pub Rc<RefCell<Registers>>);

impl Chip {
    pub fn new() -> Self {
        let mut registers = Registers {
            memory: [0xaa; 128],
            wiring: Wiring::Sound,
            offences: vec![],
            transactions: 0,
            oscillator_starts_after: 0,
        };
        registers.reset();
        Self(Rc::new(RefCell::new(registers)))
    }

    pub fn get(&self, address: usize) -> u8 {
        self.0.borrow().memory[address]
    }

    pub fn set(&self, address: usize, value: u8) {
        self.0.borrow_mut().memory[address] = value;
    }

    /// INT is low.
    pub fn interrupts(&self) -> bool {
        self.get(CANINTF) & self.get(CANINTE) != 0
    }

    pub fn mode(&self) -> u8 {
        self.get(CANSTAT) >> 5
    }

    /// A data frame comes on the bus. Figure 4-3: acceptance, rollover, overflow.
    pub fn hear(&self, identifier: u16, payload: &[u8]) {
        let mut image = [0; 13];
        image[0] = (identifier >> 3) as u8;
        image[1] = (identifier << 5) as u8;
        image[4] = payload.len() as u8;
        image[5..5 + payload.len()].copy_from_slice(payload);
        self.hear_image(identifier, image);
    }

    pub fn hear_image(&self, identifier: u16, image: [u8; 13]) {
        let mut chip = self.0.borrow_mut();
        if chip.memory[CANSTAT] >> 5 != 0 {
            return;
        }
        let takes = |chip: &Registers, filters: std::ops::Range<usize>, mask: usize| {
            let mask = chip.identifier_at(MASKS[mask]);
            FILTERS[filters]
                .iter()
                .any(|filter| (chip.identifier_at(*filter) ^ identifier) & mask == 0)
        };
        let full = [chip.memory[CANINTF] & 1 != 0, chip.memory[CANINTF] & 2 != 0];
        let rollover = chip.memory[RECEIVE[0]] & 4 != 0;
        let buffer = if takes(&chip, 0..2, 0) {
            match (full, rollover) {
                ([false, _], _) => 0,
                ([true, false], true) => 1,
                ([true, true], true) => return chip.overflow(1),
                ([true, _], false) => return chip.overflow(0),
            }
        } else if takes(&chip, 2..6, 1) {
            if full[1] {
                return chip.overflow(1);
            }
            1
        } else {
            return;
        };
        let at = RECEIVE[buffer] + 1;
        chip.memory[at..at + 13].copy_from_slice(&image);
        chip.memory[CANINTF] |= 1 << buffer;
    }

    /// The bus is free: the waiting buffer with the highest priority is sent (section 3.2) and acknowledged.
    pub fn speak(&self) -> Option<OnBus> {
        let mut chip = self.0.borrow_mut();
        if chip.memory[CANSTAT] >> 5 != 0 || chip.memory[EFLG] & 0x20 != 0 {
            return None;
        }
        let buffer = (0..3)
            .filter(|n| chip.memory[TRANSMIT[*n]] & 8 != 0)
            .max_by_key(|n| (chip.memory[TRANSMIT[*n]] & 3, *n))?;
        let at = TRANSMIT[buffer];
        chip.memory[at] &= !8;
        chip.memory[CANINTF] |= 4 << buffer;
        let length = usize::from(chip.memory[at + 5] & 15);
        let payload = chip.memory[at + 6..at + 6 + length].to_vec();
        Some((chip.identifier_at(at + 1), payload))
    }

    /// Error counters move, with the flags and the interrupt that follow from them (section 6.6).
    pub fn errors(&self, transmit: u16, receive: u8) {
        let mut chip = self.0.borrow_mut();
        chip.memory[TEC] = transmit.min(255) as u8;
        chip.memory[REC] = receive;
        let mut flags = chip.memory[EFLG] & 0xc0;
        flags |= u8::from(transmit > 255) << 5;
        flags |= u8::from(transmit > 127) << 4 | u8::from(receive > 127) << 3;
        flags |= u8::from(transmit >= 96) << 2 | u8::from(receive >= 96) << 1;
        flags |= u8::from(transmit >= 96 || receive >= 96);
        if flags & !chip.memory[EFLG] != 0 {
            chip.memory[CANINTF] |= 0x20;
        }
        chip.memory[EFLG] = flags;
    }

    /// A frame fault on the bus.
    pub fn message_error(&self) {
        self.0.borrow_mut().memory[CANINTF] |= 0x80;
    }

    pub fn offences(&self) -> Vec<String> {
        self.0.borrow().offences.clone()
    }
}

impl Registers {
    fn identifier_at(&self, address: usize) -> u16 {
        u16::from(self.memory[address]) << 3 | u16::from(self.memory[address + 1]) >> 5
    }

    /// Register values after a reset (section 11); those that are undefined keep what was there.
    pub fn reset(&mut self) {
        for address in [CANINTE, CANINTF, EFLG, TEC, REC, 0x28, 0x29, 0x2a]
            .iter()
            .chain(&TRANSMIT)
            .chain(&RECEIVE)
        {
            self.memory[*address] = 0;
        }
        self.memory[CANCTRL] = 0x87;
        self.memory[CANSTAT] = 0x80;
    }

    fn overflow(&mut self, buffer: usize) {
        self.memory[EFLG] |= 0x40 << buffer;
        self.memory[CANINTF] |= 0x20;
    }

    fn write(&mut self, address: usize, value: u8) {
        let configuring = self.memory[CANSTAT] >> 5 == 4;
        let protected = matches!(address, 0x00..=0x0b | 0x10..=0x1b | 0x20..=0x2a);
        if protected && !configuring {
            self.offences.push(format!(
                "register {address:#04x} outside of configuration mode"
            ));
            return;
        }
        if let Some(buffer) = TRANSMIT
            .iter()
            .find(|at| (**at..**at + 14).contains(&address))
        {
            let clears_request =
                address == *buffer && value & 8 == 0 && self.memory[*buffer] & 8 != 0;
            if self.memory[*buffer] & 8 != 0 && !clears_request {
                self.offences
                    .push(format!("transmit buffer at {buffer:#04x} while it waits"));
                return;
            }
        }
        match address {
            CANSTAT | 0x1e | 0x1f | TEC | REC => self
                .offences
                .push(format!("read-only register {address:#04x}")),
            CANCTRL => {
                self.memory[CANCTRL] = value;
                let stuck = self.wiring == Wiring::BusHeldLow;
                if !(stuck && value >> 5 == 0) {
                    self.memory[CANSTAT] = self.memory[CANSTAT] & 0x1f | value & 0xe0;
                }
            }
            // Only the overflow flags can be written.
            EFLG => self.memory[EFLG] = self.memory[EFLG] & 0x3f | value & 0xc0,
            _ => self.memory[address & 0x7f] = value,
        }
    }

    fn modify(&mut self, address: usize, mask: u8, value: u8) {
        let can_be_modified = matches!(
            address,
            0x0c | 0x0d | CANCTRL | 0x28..=0x2d | 0x30 | 0x40 | 0x50 | 0x60 | 0x70
        );
        if !can_be_modified {
            self.offences.push(format!("bit modify of {address:#04x}"));
            return;
        }
        let old = self.memory[address];
        self.write(address, old & !mask | value & mask);
    }

    /// One transaction, CS low to CS high.
    fn exchange(&mut self, out: &[u8]) -> Vec<u8> {
        self.transactions += 1;
        let mut answer = vec![0; out.len()];
        if self.oscillator_starts_after > 0 {
            self.oscillator_starts_after -= 1;
            return answer;
        }
        match *out {
            [0xc0, ..] => self.reset(),
            [0x03, address, ..] => {
                for (i, slot) in answer.iter_mut().enumerate().skip(2) {
                    *slot = self.memory[(usize::from(address) + i - 2) & 0x7f];
                }
            }
            [0x02, address, ref values @ ..] => {
                for (i, value) in values.iter().enumerate() {
                    self.write((usize::from(address) + i) & 0x7f, *value);
                }
            }
            [0x05, address, mask, value] => self.modify(usize::from(address), mask, value),
            [code, ..] if code & 0xf9 == 0x90 => {
                let buffer = usize::from(code >> 2 & 1);
                let from = RECEIVE[buffer] + if code & 2 == 0 { 1 } else { 6 };
                for (i, slot) in answer.iter_mut().enumerate().skip(1) {
                    *slot = self.memory[from + i - 1];
                }
                self.memory[CANINTF] &= !(1 << buffer);
            }
            [code] if code & 0xf8 == 0x80 => {
                for (n, at) in TRANSMIT.iter().enumerate() {
                    if code >> n & 1 != 0 {
                        self.memory[*at] |= 8;
                    }
                }
            }
            _ => self.offences.push(format!("instruction {out:02x?}")),
        }
        answer
    }
}

impl ErrorType for Chip {
    type Error = Infallible;
}

impl SpiDevice for Chip {
    async fn transaction(
        &mut self,
        operations: &mut [Operation<'_, u8>],
    ) -> Result<(), Infallible> {
        let mut out = vec![];
        for operation in operations.iter() {
            match operation {
                Operation::Write(bytes) => out.extend_from_slice(bytes),
                Operation::Read(bytes) => out.extend(std::iter::repeat_n(0, bytes.len())),
                _ => unimplemented!("the driver writes and reads"),
            }
        }
        let wiring = self.0.borrow().wiring;
        let answer = match wiring {
            Wiring::Reads(level) => vec![level; out.len()],
            _ => self.0.borrow_mut().exchange(&out),
        };
        let mut at = 0;
        for operation in operations {
            match operation {
                Operation::Write(bytes) => at += bytes.len(),
                Operation::Read(bytes) => {
                    bytes.copy_from_slice(&answer[at..at + bytes.len()]);
                    at += bytes.len();
                }
                _ => {}
            }
        }
        Ok(())
    }
}

/// Adds up what was waited for.
#[derive(Default)]
pub struct Clock {
    pub waited_us: u64,
}

impl DelayNs for Clock {
    async fn delay_ns(&mut self, nanoseconds: u32) {
        self.waited_us += u64::from(nanoseconds / 1000);
    }
}

/// Nothing in these tests ever waits.
pub fn block_on<F: Future>(future: F) -> F::Output {
    let mut future = pin!(future);
    match future
        .as_mut()
        .poll(&mut Context::from_waker(Waker::noop()))
    {
        Poll::Ready(value) => value,
        Poll::Pending => panic!("the chip of these tests answers at once"),
    }
}
