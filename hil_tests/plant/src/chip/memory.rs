//! What the processor reaches without the help of a peripheral: boot ROM, flash and SRAM (RP2040 datasheet 2.2).

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyByteArray, PyByteArrayMethods};

/// Flash is seen four times, with and without its cache.
const FLASH_END: u32 = 0x1400_0000;
const FLASH_MASK: u32 = 0x00FF_FFFF;
const SRAM_BASE: u32 = 0x2000_0000;
/// Buffers of the USB controller (4.1.2.7): memory of its own, without a host at the other end of the cable.
const USB_BASE: u32 = 0x5010_0000;
const USB_END: u32 = 0x5010_1000;

/// A bytearray that Python and the processor share.
struct Shared {
    _owner: Py<PyByteArray>,
    data: *mut u8,
    length: usize,
}

impl Shared {
    fn new(array: &Bound<'_, PyByteArray>) -> Self {
        Self {
            _owner: array.clone().unbind(),
            data: array.data(),
            length: array.len(),
        }
    }

    fn read<const N: usize>(&self, offset: usize) -> Option<[u8; N]> {
        if offset + N > self.length {
            return None;
        }
        // SAFETY: within the array, which lives as long as its owner here and is never resized (`Memory::new`).
        Some(unsafe { self.data.add(offset).cast::<[u8; N]>().read_unaligned() })
    }

    fn write<const N: usize>(&self, offset: usize, bytes: [u8; N]) -> bool {
        if offset + N > self.length {
            return false;
        }
        // SAFETY: as for `read`; the interpreter's lock is held while the processor runs.
        unsafe {
            self.data
                .add(offset)
                .cast::<[u8; N]>()
                .write_unaligned(bytes);
        }
        true
    }
}

/// ROM of its own, and three arrays that Python shares.
pub struct Memory {
    rom: Vec<u8>,
    flash: Shared,
    sram: Shared,
    usb: Shared,
}

impl Memory {
    /// The arrays must keep their sizes as long as the processor lives.
    pub fn new(
        rom: &[u8],
        flash: &Bound<'_, PyByteArray>,
        sram: &Bound<'_, PyByteArray>,
        usb: &Bound<'_, PyByteArray>,
    ) -> PyResult<Self> {
        if flash.len() <= FLASH_MASK as usize {
            return Err(PyValueError::new_err("flash must span 16 MiB"));
        }
        Ok(Self {
            rom: rom.to_vec(),
            flash: Shared::new(flash),
            sram: Shared::new(sram),
            usb: Shared::new(usb),
        })
    }

    /// N bytes at `address`; None when no memory is there.
    #[inline]
    pub fn read<const N: usize>(&self, address: u32) -> Option<[u8; N]> {
        match address >> 28 {
            1 if address < FLASH_END => self.flash.read((address & FLASH_MASK) as usize),
            2 => self.sram.read((address - SRAM_BASE) as usize),
            0 => {
                let from = address as usize;
                self.rom.get(from..from + N)?.try_into().ok()
            }
            5 if (USB_BASE..USB_END).contains(&address) => {
                self.usb.read((address - USB_BASE) as usize)
            }
            _ => None,
        }
    }

    /// Writes to SRAM; false when something else is at `address`. Flash and ROM take no writes.
    #[inline]
    pub fn write<const N: usize>(&self, address: u32, bytes: [u8; N]) -> bool {
        match address >> 28 {
            2 => self.sram.write((address - SRAM_BASE) as usize, bytes),
            5 if (USB_BASE..USB_END).contains(&address) => {
                self.usb.write((address - USB_BASE) as usize, bytes)
            }
            0 => true,
            1 => address < FLASH_END,
            _ => false,
        }
    }
}
