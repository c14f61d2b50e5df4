//! Processor, memory, clock and bus together: what Python sees of the fast half of the chip.

use std::cell::RefCell;
use std::collections::HashMap;
use std::rc::Rc;

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::{PyByteArray, PyDict};

use super::bus::{Signals, Wiring};
use super::clock::{Clock, Time};
use super::core::{Core, Fault, Sleep, PC};
use super::memory::Memory;
use super::sio::Sio;
use super::timer::Timer;

struct Chip {
    core: Core,
    memory: Memory,
    sio: Sio,
    timer: Timer,
    peripherals: HashMap<u32, Py<PyAny>>,
    pins: Option<Py<PyAny>>,
    cycle: u64,
    instructions: u64,
    asleep: u64,
}

/// The processor of one chip. `run_until` may call Python peripherals, and those may call everything here but
/// `run_until` and the registers.
#[pyclass(unsendable, frozen, module = "rover_plant")]
pub struct Processor {
    time: Rc<Time>,
    signals: Rc<Signals>,
    chip: RefCell<Chip>,
}

#[pymethods]
impl Processor {
    /// `rom`: boot ROM; `flash` (16 MiB), `sram` and `usb` are shared and must not change their sizes.
    #[new]
    fn new(
        clock: &Clock,
        rom: &[u8],
        flash: &Bound<'_, PyByteArray>,
        sram: &Bound<'_, PyByteArray>,
        usb: &Bound<'_, PyByteArray>,
    ) -> PyResult<Self> {
        let chip = Chip {
            core: Core::default(),
            memory: Memory::new(rom, flash, sram, usb)?,
            sio: Sio::default(),
            timer: Timer::default(),
            peripherals: HashMap::new(),
            pins: None,
            cycle: 0,
            instructions: 0,
            asleep: 0,
        };
        let signals = Rc::new(Signals::default());
        signals.reset.set(true);
        Ok(Self {
            time: Rc::clone(&clock.time),
            signals,
            chip: RefCell::new(chip),
        })
    }

    /// `peripherals`: base address to an object with `read_uint32(offset)` and
    /// `write_uint32_atomic(offset, value, kind)`; `pins`: the SIO's other registers, with
    /// `read_uint32(offset)` and `write_uint32(offset, value)`.
    fn connect(&self, peripherals: &Bound<'_, PyDict>, pins: Py<PyAny>) -> PyResult<()> {
        let mut chip = self.chip.borrow_mut();
        chip.peripherals.clear();
        for (base, object) in peripherals {
            chip.peripherals.insert(base.extract()?, object.unbind());
        }
        chip.pins = Some(pins);
        Ok(())
    }

    /// Runs up to that cycle, a few cycles further when an instruction crosses it. Raises what a peripheral raises,
    /// RuntimeError when the processor locks up.
    fn run_until(&self, py: Python<'_>, cycle: u64) -> PyResult<()> {
        let mut chip = self.chip.borrow_mut();
        let Chip {
            core,
            memory,
            sio,
            timer,
            peripherals,
            pins,
            cycle: now,
            instructions,
            asleep,
        } = &mut *chip;
        let signals = &*self.signals;
        let mut bus = Wiring {
            py,
            memory,
            sio,
            timer,
            peripherals,
            pins: pins.as_ref(),
            time: &self.time,
            signals,
            error: None,
        };
        while *now < cycle && !signals.stop.get() {
            if signals.reset.replace(false) {
                *bus.sio = Sio::default();
                *bus.timer = Timer::start(*now);
                *core = Core::reset(&mut bus).map_err(|_| locked_up(0))?;
            }
            if self.time.next_due() <= *now {
                self.time.fire(py, *now)?;
            }
            if bus.timer.next_due() <= *now {
                bus.timer.advance(*now);
                signals.changed.set(true);
            }
            if signals.changed.replace(false) {
                core.nvic.set_lines(
                    signals.lines.get() | bus.timer.lines(),
                    signals.risen.take(),
                );
                core.check = true;
            }
            let limit = cycle.min(self.time.next_due()).min(bus.timer.next_due());
            while *now < limit {
                if core.check {
                    core.check = false;
                    match core.take_exception(&mut bus) {
                        Ok(cycles) => *now += cycles,
                        Err(_) => return Err(locked_up(core.r[PC])),
                    }
                }
                if core.sleep != Sleep::Awake {
                    *asleep += limit - *now;
                    *now = limit;
                    break;
                }
                let here = core.r[PC];
                self.time.set(*now);
                *instructions += 1;
                match core.step(&mut bus) {
                    Ok(cycles) => *now += cycles,
                    Err(Fault::Hard) => {
                        core.r[PC] = here;
                        match core.hard_fault(&mut bus) {
                            Ok(cycles) => *now += cycles,
                            Err(_) => return Err(locked_up(here)),
                        }
                    }
                    Err(Fault::Peripheral) => {
                        return Err(bus.error.take().unwrap_or_else(|| locked_up(here)))
                    }
                }
                if signals.changed.get() {
                    break;
                }
            }
        }
        self.time.set(*now);
        Ok(())
    }

    /// Level of an interrupt line.
    fn set_interrupt(&self, irq: u32, value: bool) {
        let before = self.signals.lines.get();
        let after = if value {
            before | 1 << irq
        } else {
            before & !(1 << irq)
        };
        if before != after {
            self.signals.lines.set(after);
            self.signals
                .risen
                .set(self.signals.risen.get() | (after & !before));
            self.signals.changed.set(true);
        }
    }

    /// Starts anew from the boot ROM before the next instruction.
    fn reset(&self) {
        self.signals.reset.set(true);
        self.signals.changed.set(true);
    }

    /// Makes `run_until` return after the present instruction, until it is released.
    #[setter]
    fn set_stopped(&self, stopped: bool) {
        self.signals.stop.set(stopped);
        self.signals.changed.set(true);
    }

    #[getter]
    fn stopped(&self) -> bool {
        self.signals.stop.get()
    }

    /// Interrupts that are routed to the NMI (SYSCFG); stored only, as the firmware routes none.
    #[getter]
    fn interrupt_nmi_mask(&self) -> u32 {
        self.signals.nmi_mask.get()
    }

    #[setter]
    fn set_interrupt_nmi_mask(&self, mask: u32) {
        self.signals.nmi_mask.set(mask);
    }

    /// Registers r0 to r15, for tests and debugging.
    #[getter]
    fn registers(&self) -> [u32; 16] {
        self.chip.borrow().core.r
    }

    /// Number of the exception that is handled; 0 in thread mode.
    #[getter]
    fn exception(&self) -> u32 {
        self.chip.borrow().core.exception
    }

    /// Takes an interrupt's enable away, as no program would: a fault for tests of the watchdog.
    fn disable_interrupt(&self, irq: u32) {
        self.chip.borrow_mut().core.nvic.enabled &= !(1 << irq);
    }

    /// Gives an interrupt its enable back.
    fn enable_interrupt(&self, irq: u32) {
        self.chip.borrow_mut().core.nvic.enabled |= 1 << irq;
        self.signals.changed.set(true);
    }

    /// Targets of the timer's four alarms, low 32 bits of microseconds.
    #[getter]
    fn timer_targets(&self) -> [u32; 4] {
        self.chip.borrow().timer.targets()
    }

    /// Instructions carried out so far.
    #[getter]
    fn instructions(&self) -> u64 {
        self.chip.borrow().instructions
    }

    /// Cycles slept through so far.
    #[getter]
    fn cycles_asleep(&self) -> u64 {
        self.chip.borrow().asleep
    }
}

fn locked_up(address: u32) -> PyErr {
    PyRuntimeError::new_err(format!(
        "the emulated processor has locked up at 0x{address:08x}"
    ))
}
