//! Exceptions and the interrupt controller (ARMv6-M Architecture Reference Manual, B1.5 and B3.4).

use super::alu::Flags;
use super::core::{Bus, Core, Fault, Sleep, LR, PC, SP};

/// Number of the HardFault exception.
pub const HARD_FAULT: u32 = 3;
const NMI: u32 = 2;
const SVCALL: u32 = 11;
const PENDSV: u32 = 14;
const SYSTICK: u32 = 15;
const FIRST_INTERRUPT: u32 = 16;

/// Cycles from the last instruction to the first one of the handler, and back (Cortex-M0+ TRM 3.3: 15).
const ENTRY_CYCLES: u64 = 15;
const RETURN_CYCLES: u64 = 10;

/// Priority of code that no exception has interrupted; numbers below go first.
const THREAD: i32 = 4;

/// Which exceptions are pending, enabled and active.
#[derive(Clone, Default)]
pub struct Nvic {
    /// Interrupts that may be taken, a bit each.
    pub enabled: u32,
    /// Pended by an edge of a line or by software, until its handler is entered.
    pub latched: u32,
    /// Levels of the lines when last looked at.
    pub lines: u32,
    active: u32,
    priority: [u8; 32],
    pend_sv: bool,
    sv_call: bool,
    sys_tick: bool,
    system_priority: [u32; 2],
    vector_table: u32,
}

impl Nvic {
    /// Takes the present levels of the lines in, and those that rose meanwhile: a line that rises is pended.
    pub fn set_lines(&mut self, lines: u32, risen: u32) {
        self.latched |= risen | (lines & !self.lines);
        self.lines = lines;
    }

    fn pending(&self) -> u32 {
        self.latched | (self.lines & !self.active)
    }

    fn priority_of(&self, exception: u32) -> i32 {
        match exception {
            0 => THREAD,
            1..=HARD_FAULT => exception as i32 - 4,
            SVCALL => (self.system_priority[0] >> 30) as i32,
            PENDSV => (self.system_priority[1] >> 22 & 3) as i32,
            SYSTICK => (self.system_priority[1] >> 30) as i32,
            FIRST_INTERRUPT..=47 => {
                i32::from(self.priority[(exception - FIRST_INTERRUPT) as usize])
            }
            _ => THREAD,
        }
    }

    /// The pending exception that goes first: the smallest priority, then the smallest number.
    fn first(&self) -> Option<(i32, u32)> {
        let mut best: Option<(i32, u32)> = None;
        let mut offer = |exception: u32| {
            let candidate = (self.priority_of(exception), exception);
            best = Some(best.map_or(candidate, |other| other.min(candidate)));
        };
        for (pending, exception) in [
            (self.sv_call, SVCALL),
            (self.pend_sv, PENDSV),
            (self.sys_tick, SYSTICK),
        ] {
            if pending {
                offer(exception);
            }
        }
        let mut interrupts = self.pending() & self.enabled;
        while interrupts != 0 {
            offer(FIRST_INTERRUPT + interrupts.trailing_zeros());
            interrupts &= interrupts - 1;
        }
        best
    }

    /// SVC was carried out.
    pub fn request_svcall(&mut self) {
        self.sv_call = true;
    }

    /// Register at `offset` of the system control space, 0xE000E000.
    pub fn read(&self, offset: u32, exception: u32) -> u32 {
        match offset {
            0x100 | 0x180 => self.enabled,
            0x200 | 0x280 => self.pending(),
            0x400..=0x41C => {
                let first = (offset - 0x400) as usize;
                (0..4).fold(0, |value, byte| {
                    value | u32::from(self.priority[first + byte]) << (8 * byte + 6)
                })
            }
            // SysTick: not fitted with a clock here; the firmware uses the timer.
            0x010..=0x018 => 0,
            0x01C => 0x270F,
            0xD00 => 0x410C_C601,
            0xD04 => {
                let next = self.first().map_or(0, |(_, exception)| exception);
                u32::from(self.pend_sv) << 28
                    | u32::from(self.sys_tick) << 26
                    | u32::from(self.pending() != 0) << 22
                    | next << 12
                    | exception
            }
            0xD08 => self.vector_table,
            0xD1C => self.system_priority[0],
            0xD20 => self.system_priority[1],
            _ => 0,
        }
    }

    /// Register at `offset` of the system control space.
    pub fn write(&mut self, offset: u32, value: u32) {
        match offset {
            0x100 => self.enabled |= value,
            0x180 => self.enabled &= !value,
            0x200 => self.latched |= value,
            0x280 => self.latched &= !value,
            0x400..=0x41C => {
                let first = (offset - 0x400) as usize;
                for byte in 0..4 {
                    self.priority[first + byte] = (value >> (8 * byte + 6) & 3) as u8;
                }
            }
            0xD04 => {
                self.pend_sv = (self.pend_sv || value & 1 << 28 != 0) && value & 1 << 27 == 0;
                self.sys_tick = (self.sys_tick || value & 1 << 26 != 0) && value & 1 << 25 == 0;
            }
            0xD08 => self.vector_table = value & !0xFF,
            0xD1C => self.system_priority[0] = value,
            0xD20 => self.system_priority[1] = value,
            _ => {}
        }
    }

    fn enter(&mut self, exception: u32) {
        match exception {
            SVCALL => self.sv_call = false,
            PENDSV => self.pend_sv = false,
            SYSTICK => self.sys_tick = false,
            FIRST_INTERRUPT.. => {
                self.latched &= !(1 << (exception - FIRST_INTERRUPT));
                self.active |= 1 << (exception - FIRST_INTERRUPT);
            }
            _ => {}
        }
    }

    fn leave(&mut self, exception: u32) {
        if exception >= FIRST_INTERRUPT {
            self.active &= !(1 << (exception - FIRST_INTERRUPT));
        }
    }
}

impl Core {
    /// Wakes and enters what is pending; returns the cycles that it took.
    pub fn take_exception(&mut self, bus: &mut impl Bus) -> Result<u64, Fault> {
        let running = self.nvic.priority_of(self.exception);
        let Some((priority, exception)) = self.nvic.first() else {
            return Ok(0);
        };
        if priority >= running {
            return Ok(0);
        }
        if self.masked && priority >= 0 {
            // PRIMASK keeps the handler away, and wakes a WFI nevertheless (B1.5.19).
            if self.sleep == Sleep::Interrupt {
                self.sleep = Sleep::Awake;
            }
            return Ok(0);
        }
        self.enter(bus, exception)?;
        Ok(ENTRY_CYCLES)
    }

    /// A fault at the present instruction. Fails when a fault comes while one is handled: the processor locks up.
    pub fn hard_fault(&mut self, bus: &mut impl Bus) -> Result<u64, Fault> {
        if matches!(self.exception, NMI | HARD_FAULT) {
            return Err(Fault::Hard);
        }
        self.enter(bus, HARD_FAULT)?;
        Ok(ENTRY_CYCLES)
    }

    fn enter(&mut self, bus: &mut impl Bus, exception: u32) -> Result<(), Fault> {
        let odd = self.r[SP] & 4;
        let frame = self.r[SP].wrapping_sub(0x20) & !7;
        let status = self.flags.pack() | self.exception | 1 << 24 | odd << 7;
        let saved = [
            self.r[0], self.r[1], self.r[2], self.r[3], self.r[12], self.r[LR], self.r[PC], status,
        ];
        for (index, value) in saved.into_iter().enumerate() {
            bus.store(frame + 4 * index as u32, 4, value)?;
        }
        self.r[SP] = frame;
        self.r[LR] = match (self.handler, self.process_stack) {
            (true, _) => 0xFFFF_FFF1,
            (false, false) => 0xFFFF_FFF9,
            (false, true) => 0xFFFF_FFFD,
        };
        self.handler = true;
        self.exception = exception;
        self.switch_stack(false);
        self.event = true;
        self.sleep = Sleep::Awake;
        self.nvic.enter(exception);
        self.r[PC] = bus.load(self.nvic.vector_table + 4 * exception, 4)? & !1;
        Ok(())
    }

    /// EXC_RETURN in a handler (B1.5.8); returns the cycles that it took.
    pub fn return_from_exception(&mut self, bus: &mut impl Bus, how: u32) -> Result<u64, Fault> {
        self.nvic.leave(self.exception);
        match how & 0xF {
            0b0001 => self.switch_stack(false),
            0b1001 => {
                self.handler = false;
                self.switch_stack(false);
            }
            0b1101 => {
                self.handler = false;
                self.switch_stack(true);
            }
            _ => return Err(Fault::Hard),
        }
        let frame = self.r[SP];
        let mut saved = [0; 8];
        for (index, value) in saved.iter_mut().enumerate() {
            *value = bus.load(frame + 4 * index as u32, 4)?;
        }
        self.r[..4].copy_from_slice(&saved[..4]);
        self.r[12] = saved[4];
        self.r[LR] = saved[5];
        self.r[PC] = saved[6] & !1;
        let status = saved[7];
        self.r[SP] = (frame + 0x20) | (status >> 7 & 4);
        self.flags = Flags::unpack(status);
        self.exception = status & 0x3F;
        self.event = true;
        self.check = true;
        Ok(RETURN_CYCLES)
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_bus::{booted, TestBus, HANDLER, STACK};
    use super::*;

    const IRQ: u32 = 5;

    /// A core in thread mode with one interrupt line that is enabled.
    fn waiting(bus: &mut TestBus) -> Core {
        bus.word(4 * (FIRST_INTERRUPT + IRQ), HANDLER | 1);
        let mut core = booted(bus);
        core.nvic.write(0x100, 1 << IRQ);
        core
    }

    #[test]
    fn an_interrupt_saves_eight_words_and_its_return_restores_them() {
        let mut bus = TestBus::default();
        let mut core = waiting(&mut bus);
        core.r[0] = 7;
        core.r[12] = 9;
        let before = core.r;
        core.nvic.set_lines(1 << IRQ, 0);
        assert_eq!(core.take_exception(&mut bus), Ok(ENTRY_CYCLES));
        assert_eq!(
            (core.r[PC], core.r[SP], core.r[LR]),
            (HANDLER, STACK - 0x20, 0xFFFF_FFF9)
        );
        assert_eq!(core.exception, FIRST_INTERRUPT + IRQ);
        core.r[0] = 0;
        core.nvic.set_lines(0, 0);
        assert_eq!(
            core.return_from_exception(&mut bus, 0xFFFF_FFF9),
            Ok(RETURN_CYCLES)
        );
        assert_eq!(core.r, before);
        assert_eq!(core.exception, 0);
    }

    #[test]
    fn priorities_decide_who_interrupts_whom() {
        let mut bus = TestBus::default();
        let mut core = waiting(&mut bus);
        core.nvic.write(0x100, 3 << IRQ);
        core.nvic.write(0x404, 3 << 14);
        core.nvic.set_lines(3 << IRQ, 0);
        core.take_exception(&mut bus).unwrap();
        assert_eq!(
            core.exception,
            FIRST_INTERRUPT + IRQ + 1,
            "the one with the smaller number of priority"
        );
        assert_eq!(core.take_exception(&mut bus), Ok(0), "the other waits");
    }

    #[test]
    fn a_mask_keeps_the_handler_away_and_still_wakes() {
        let mut bus = TestBus::default();
        let mut core = waiting(&mut bus);
        core.masked = true;
        core.sleep = Sleep::Interrupt;
        core.nvic.set_lines(1 << IRQ, 0);
        assert_eq!(core.take_exception(&mut bus), Ok(0));
        assert_eq!((core.sleep, core.exception), (Sleep::Awake, 0));
    }

    #[test]
    fn a_fault_in_the_handler_of_a_fault_locks_up() {
        let mut bus = TestBus::default();
        let mut core = waiting(&mut bus);
        assert!(core.hard_fault(&mut bus).is_ok());
        assert_eq!(core.hard_fault(&mut bus), Err(Fault::Hard));
    }
}
