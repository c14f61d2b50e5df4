//! Entry into exceptions and return from them (ARMv6-M Architecture Reference Manual, B1.5).

use super::alu::Flags;
use super::core::{Bus, Core, Fault, Sleep, LR, PC, SP};
use super::nvic::{HARD_FAULT, NMI};

/// Cycles from the last instruction to the first one of the handler, and back (Cortex-M0+ TRM 3.3: 15).
const ENTRY_CYCLES: u64 = 15;
const RETURN_CYCLES: u64 = 10;

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
    use super::super::nvic::FIRST_INTERRUPT;
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
