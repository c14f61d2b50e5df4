//! The interrupt controller (ARMv6-M Architecture Reference Manual, B3.4): what is pending, and what goes first.

/// Number of the HardFault exception.
pub const HARD_FAULT: u32 = 3;
/// Number of the NMI.
pub const NMI: u32 = 2;
const SVCALL: u32 = 11;
const PENDSV: u32 = 14;
const SYSTICK: u32 = 15;
/// Number of interrupt 0.
pub const FIRST_INTERRUPT: u32 = 16;

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
    /// Address of the vectors.
    pub vector_table: u32,
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

    /// Of an exception by its number; 0 is thread mode.
    pub fn priority_of(&self, exception: u32) -> i32 {
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
    pub fn first(&self) -> Option<(i32, u32)> {
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

    /// Its handler is entered.
    pub fn enter(&mut self, exception: u32) {
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

    /// Its handler has returned.
    pub fn leave(&mut self, exception: u32) {
        if exception >= FIRST_INTERRUPT {
            self.active &= !(1 << (exception - FIRST_INTERRUPT));
        }
    }
}
