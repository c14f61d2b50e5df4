//! Two quadrature encoders, x4, counted by the PIO without any help from the processor.
//!
//! A state machine samples A and B, looks the step up in a table of 16 jumps (previous and new state), counts in its
//! register Y, and pushes the total after each step. The FIFO carries totals, not steps: if it is full the newest
//! total is dropped, but the next step brings all of them, so a late reader loses freshness and never a count.

use embassy_rp::bind_interrupts;
use embassy_rp::gpio::Pull;
use embassy_rp::peripherals::PIO0;
use embassy_rp::pio::program::pio_asm;
use embassy_rp::pio::{
    Common, Config, Direction, FifoJoin, InterruptHandler, LoadedProgram, Pin, Pio, ShiftDirection,
    StateMachine,
};
use embassy_rp::pio_programs::clock_divider::calculate_pio_clock_divider;

use crate::pins::{EncoderPins, LEFT_ENCODER_SIGN, RIGHT_ENCODER_SIGN};

bind_interrupts!(struct Irqs {
    PIO0_IRQ_0 => InterruptHandler<PIO0>;
});

/// A step takes at most 11 cycles, so 45,000 steps a second: ten times the fastest wheel (0.6 m/s, 0.13 mm a count).
const PIO_HZ: u32 = 500_000;

struct Counter<const SM: usize> {
    machine: StateMachine<'static, PIO0, SM>,
    sign: i32,
    total: i32,
}

impl<const SM: usize> Counter<SM> {
    fn new(
        mut machine: StateMachine<'static, PIO0, SM>,
        program: &LoadedProgram<'static, PIO0>,
        a: &Pin<'static, PIO0>,
        b: &Pin<'static, PIO0>,
        sign: i32,
    ) -> Self {
        machine.set_pin_dirs(Direction::In, &[a, b]);
        let mut config = Config::default();
        config.use_program(program, &[]);
        config.set_in_pins(&[a, b]);
        config.shift_in.direction = ShiftDirection::Left;
        config.fifo_join = FifoJoin::RxOnly;
        config.clock_divider = calculate_pio_clock_divider(PIO_HZ);
        machine.set_config(&config);
        // SAFETY: the machine is not running, so no program is disturbed. Y is not defined after a reset.
        unsafe {
            machine.set_x(0);
            machine.set_y(0);
        }
        machine.set_enable(true);
        Self {
            machine,
            sign,
            total: 0,
        }
    }

    fn read(&mut self) -> i32 {
        while let Some(total) = self.machine.rx().try_pull() {
            self.total = total as i32;
        }
        self.total.wrapping_mul(self.sign)
    }
}

/// Both encoders.
pub struct Encoders {
    left: Counter<0>,
    right: Counter<1>,
}

impl Encoders {
    pub fn new(pins: EncoderPins) -> Self {
        let Pio {
            mut common,
            sm0,
            sm1,
            ..
        } = Pio::new(pins.pio, Irqs);
        let program = load(&mut common);
        let pin = |mut pin: Pin<'static, PIO0>| {
            pin.set_pull(Pull::Up);
            pin
        };
        let left_a = pin(common.make_pio_pin(pins.left_a));
        let left_b = pin(common.make_pio_pin(pins.left_b));
        let right_a = pin(common.make_pio_pin(pins.right_a));
        let right_b = pin(common.make_pio_pin(pins.right_b));
        Self {
            left: Counter::new(sm0, &program, &left_a, &left_b, LEFT_ENCODER_SIGN),
            right: Counter::new(sm1, &program, &right_a, &right_b, RIGHT_ENCODER_SIGN),
        }
    }

    /// Totals since boot, left and right, positive forwards; they wrap.
    pub fn read(&mut self) -> (i32, i32) {
        (self.left.read(), self.right.read())
    }
}

/// The table must lie at address 0, as `mov pc` jumps to previous state * 4 + new state, each state B * 2 + A.
///
/// X holds that number from one sample to the next: its two lower bits are the previous state then. A step in which
/// both bits change is a glitch and is not counted.
fn load(common: &mut Common<'static, PIO0>) -> LoadedProgram<'static, PIO0> {
    let program = pio_asm!(
        ".origin 0",
        "    jmp sample", // 00 -> 00
        "    jmp up",     // 00 -> 01, A rises first
        "    jmp down",   // 00 -> 10
        "    jmp sample", // 00 -> 11
        "    jmp down",   // 01 -> 00
        "    jmp sample", // 01 -> 01
        "    jmp sample", // 01 -> 10
        "    jmp up",     // 01 -> 11
        "    jmp up",     // 10 -> 00
        "    jmp sample", // 10 -> 01
        "    jmp sample", // 10 -> 10
        "    jmp down",   // 10 -> 11
        "    jmp sample", // 11 -> 00
        "    jmp down",   // 11 -> 01
        "    jmp up",     // 11 -> 10
        "    jmp sample", // 11 -> 11
        "up:",            // there is no increment: y + 1 = !(!y - 1)
        "    mov y, ~y",
        "    jmp y--, negate",
        "negate:",
        "    mov y, ~y",
        "    jmp report",
        "down:",
        "    jmp y--, report",
        "report:",
        "    mov isr, y",
        "    push noblock",
        "sample:",
        "    mov isr, null",
        "    in x, 2",
        "    in pins, 2",
        "    mov x, isr",
        "    mov pc, isr",
    );
    common.load_program(&program.program)
}
