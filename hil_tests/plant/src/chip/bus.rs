//! Where the processor's loads and stores go: memory, the SIO, the timer, and the peripherals in Python.

use std::cell::Cell;
use std::collections::HashMap;

use pyo3::intern;
use pyo3::prelude::*;

use super::clock::Time;
use super::core::{Bus, Fault};
use super::memory::Memory;
use super::sio::{Sio, Written};
use super::timer::Timer;

const SIO: u32 = 0xD;
const TIMER_BASE: u32 = 0x4005_4000;
/// A peripheral's 16 KiB: registers, and their xor, set and clear aliases (RP2040 datasheet 2.1.2).
const PAGE: u32 = !0x3FFF;

/// What Python changes while the processor runs.
#[derive(Default)]
pub struct Signals {
    /// Levels of the interrupt lines.
    pub lines: Cell<u32>,
    /// Lines that have risen since the processor last looked, if only for a moment.
    pub risen: Cell<u32>,
    /// Look at lines, alarms and requests again.
    pub changed: Cell<bool>,
    /// Start anew before the next instruction.
    pub reset: Cell<bool>,
    /// Come out of `run_until`.
    pub stop: Cell<bool>,
    /// Kept for reading back only.
    pub nmi_mask: Cell<u32>,
}

/// Everything that an access may reach, for the length of one `run_until`.
pub struct Wiring<'a, 'py> {
    /// Proof that the interpreter's lock is held.
    pub py: Python<'py>,
    /// ROM, flash, SRAM and the USB buffers.
    pub memory: &'a mut Memory,
    /// Divider, spinlocks and output registers.
    pub sio: &'a mut Sio,
    /// The microsecond timer.
    pub timer: &'a mut Timer,
    /// Python's peripherals by base address.
    pub peripherals: &'a HashMap<u32, Py<PyAny>>,
    /// The SIO's registers that Python keeps.
    pub pins: Option<&'a Py<PyAny>>,
    /// Now, for what depends on it.
    pub time: &'a Time,
    /// What Python changes meanwhile.
    pub signals: &'a Signals,
    /// Why the last access has failed with [`Fault::Peripheral`].
    pub error: Option<PyErr>,
}

impl Bus for Wiring<'_, '_> {
    #[inline]
    fn fetch(&mut self, address: u32) -> Result<u16, Fault> {
        let bytes = self.memory.read(address).ok_or(Fault::Hard)?;
        Ok(u16::from_le_bytes(bytes))
    }

    #[inline]
    fn load(&mut self, address: u32, size: u32) -> Result<u32, Fault> {
        if address & (size - 1) != 0 {
            return Err(Fault::Hard);
        }
        let found = match size {
            4 => self.memory.read(address).map(u32::from_le_bytes),
            2 => self
                .memory
                .read(address)
                .map(|bytes| u32::from(u16::from_le_bytes(bytes))),
            _ => self.memory.read(address).map(|[byte]| u32::from(byte)),
        };
        match found {
            Some(value) => Ok(value),
            None => {
                let value = self.load_register(address & !3)?;
                // A narrow load takes its lane of the word.
                Ok(value >> (8 * (address & 3)) & (u32::MAX >> (32 - 8 * size)))
            }
        }
    }

    #[inline]
    fn store(&mut self, address: u32, size: u32, value: u32) -> Result<(), Fault> {
        if address & (size - 1) != 0 {
            return Err(Fault::Hard);
        }
        let done = match size {
            4 => self.memory.write(address, value.to_le_bytes()),
            2 => self.memory.write(address, (value as u16).to_le_bytes()),
            _ => self.memory.write(address, [value as u8]),
        };
        if done {
            return Ok(());
        }
        // The bus repeats a narrow value in every lane, and the registers take all of them (2.1.4).
        let word = match size {
            4 => value,
            2 => (value & 0xFFFF) * 0x0001_0001,
            _ => (value & 0xFF) * 0x0101_0101,
        };
        self.store_register(address & !3, word)
    }
}

impl Wiring<'_, '_> {
    fn load_register(&mut self, address: u32) -> Result<u32, Fault> {
        let base = address & PAGE;
        if address >> 28 == SIO {
            let offset = address & 0xFFF;
            return match self.sio.read(offset) {
                Some(value) => Ok(value),
                None => self.read_object(self.pins, offset),
            };
        }
        if base == TIMER_BASE {
            return Ok(self.timer.read(address & 0xFFF, self.time.now()));
        }
        self.read_object(self.peripherals.get(&base), address & 0xFFF)
    }

    fn store_register(&mut self, address: u32, value: u32) -> Result<(), Fault> {
        let base = address & PAGE;
        let offset = address & 0xFFF;
        if address >> 28 == SIO {
            return match self.sio.write(offset, value) {
                Written::Done => Ok(()),
                Written::Pins { register, value } => self.write_pins(register, value),
                Written::Elsewhere => self.write_pins(offset, value),
            };
        }
        let kind = address >> 12 & 3;
        if base == TIMER_BASE {
            let now = self.time.now();
            let before = match kind {
                0 => 0,
                _ => self.timer.read(offset, now),
            };
            let after = match kind {
                0 => value,
                1 => before ^ value,
                2 => before | value,
                _ => before & !value,
            };
            self.timer.write(offset, after, value, now);
            self.signals.changed.set(true);
            return Ok(());
        }
        self.write_object(self.peripherals.get(&base), offset, value, kind)
    }

    fn read_object(&mut self, object: Option<&Py<PyAny>>, offset: u32) -> Result<u32, Fault> {
        let object = object.ok_or(Fault::Hard)?;
        let result = object
            .call_method1(self.py, intern!(self.py, "read_uint32"), (offset,))
            .and_then(|value| value.extract::<i64>(self.py));
        self.signals.changed.set(true);
        result
            .map(|value| value as u32)
            .map_err(|error| self.fail(error))
    }

    /// The SIO has no aliases.
    fn write_pins(&mut self, offset: u32, value: u32) -> Result<(), Fault> {
        let object = self.pins.ok_or(Fault::Hard)?;
        let result =
            object.call_method1(self.py, intern!(self.py, "write_uint32"), (offset, value));
        self.signals.changed.set(true);
        result.map(|_| ()).map_err(|error| self.fail(error))
    }

    fn write_object(
        &mut self,
        object: Option<&Py<PyAny>>,
        offset: u32,
        value: u32,
        kind: u32,
    ) -> Result<(), Fault> {
        let object = object.ok_or(Fault::Hard)?;
        let name = intern!(self.py, "write_uint32_atomic");
        let result = object.call_method1(self.py, name, (offset, value, kind));
        self.signals.changed.set(true);
        result.map(|_| ()).map_err(|error| self.fail(error))
    }

    fn fail(&mut self, error: PyErr) -> Fault {
        self.error = Some(error);
        Fault::Peripheral
    }
}
