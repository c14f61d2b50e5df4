//! Registers of the Cortex-M0+ and the interface to the bus behind it.

use super::alu::Flags;
use super::nvic::Nvic;

/// Register of the stack pointer.
pub const SP: usize = 13;
/// Register of the return address.
pub const LR: usize = 14;
/// Register of the program counter.
pub const PC: usize = 15;

/// Why an instruction could not be carried out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// Becomes a HardFault.
    Hard,
    /// A peripheral has raised a Python exception, which the bus keeps.
    Peripheral,
}

/// What the processor reads and writes. Sizes are 1, 2 or 4 bytes.
pub trait Bus {
    /// An instruction's half word.
    fn fetch(&mut self, address: u32) -> Result<u16, Fault>;
    /// An aligned value, zero-extended.
    fn load(&mut self, address: u32, size: u32) -> Result<u32, Fault>;
    /// An aligned value.
    fn store(&mut self, address: u32, size: u32, value: u32) -> Result<(), Fault>;
}

/// Architectural state.
#[derive(Clone, Default)]
pub struct Core {
    /// r0 to r15.
    pub r: [u32; 16],
    /// Condition flags.
    pub flags: Flags,
    /// The stack pointer that is not in use: process stack unless `process_stack`.
    pub other_sp: u32,
    /// Thread mode uses the process stack.
    pub process_stack: bool,
    /// An exception is being handled.
    pub handler: bool,
    /// CONTROL.nPRIV; stored only.
    pub privileged_only: bool,
    /// PRIMASK: no exception with a configurable priority is taken.
    pub masked: bool,
    /// Number of the exception that is handled; 0 in thread mode.
    pub exception: u32,
    /// The event register that WFE looks at.
    pub event: bool,
    /// Whether it sleeps, and what wakes it.
    pub sleep: Sleep,
    /// Something has changed that decides whether an exception is taken.
    pub check: bool,
    /// The interrupt controller.
    pub nvic: Nvic,
}

/// What the processor waits for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sleep {
    /// Nothing: it runs.
    #[default]
    Awake,
    /// WFI: until an interrupt that would be taken if PRIMASK were clear.
    Interrupt,
    /// WFE: until an event; the entry into an exception is one.
    Event,
}

impl Core {
    /// After a reset: stack and program counter from the vector table at 0 (the boot ROM).
    pub fn reset(bus: &mut impl Bus) -> Result<Self, Fault> {
        let mut core = Self::default();
        core.r[SP] = bus.load(0, 4)? & !3;
        core.r[PC] = bus.load(4, 4)? & !1;
        Ok(core)
    }

    /// Changes between main and process stack.
    pub fn switch_stack(&mut self, process: bool) {
        if self.process_stack != process {
            std::mem::swap(&mut self.r[SP], &mut self.other_sp);
            self.process_stack = process;
        }
    }

    fn stack(&mut self, process: bool) -> &mut u32 {
        if self.process_stack == process {
            &mut self.r[SP]
        } else {
            &mut self.other_sp
        }
    }

    /// MRS (B5.2.2).
    pub fn special(&mut self, number: u32) -> u32 {
        match number {
            0..=3 => {
                let exception = if number & 1 != 0 { self.exception } else { 0 };
                self.flags.pack() | exception
            }
            5 => self.exception,
            8 => *self.stack(false),
            9 => *self.stack(true),
            16 => u32::from(self.masked),
            20 => u32::from(self.process_stack) << 1 | u32::from(self.privileged_only),
            _ => 0,
        }
    }

    /// MSR (B5.2.3).
    pub fn set_special(&mut self, number: u32, value: u32) {
        match number {
            0..=3 => self.flags = Flags::unpack(value),
            8 => *self.stack(false) = value & !3,
            9 => *self.stack(true) = value & !3,
            16 => {
                self.masked = value & 1 != 0;
                self.check = true;
            }
            20 => {
                self.privileged_only = value & 1 != 0;
                if !self.handler {
                    self.switch_stack(value & 2 != 0);
                }
            }
            _ => {}
        }
    }
}
