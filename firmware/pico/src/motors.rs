//! Two DC motors on an H-bridge with two inputs each (DRV8833; TB6612FNG with PWMA and PWMB tied high).
//!
//! Slow decay: one input is high and the other carries the inverted PWM, so the bridge brakes in the part of each period
//! in which it does not drive. That makes the speed nearly proportional to the duty. Duty 0 is both inputs high, the
//! brake; both low would let a TB6612 or DRV8833 coast, and so does the standby line, which is how power is taken off.

use embassy_rp::clocks::clk_sys_freq;
use embassy_rp::gpio::Output;
use embassy_rp::pac;
use embassy_rp::pwm::{Config, Pwm};

use crate::emergency;
use crate::pins::MotorPins;

/// Above hearing, far below the 100 kHz that the TB6612 takes and the 250 kHz of the DRV8833.
const FREQUENCY_HZ: u32 = 20_000;
/// The slices of [`MotorPins`].
const LEFT: usize = 3;
const RIGHT: usize = 4;

/// Compare values of IN1 and IN2 for a duty in Q15, positive forwards, of a PWM with `period` steps. A compare value of
/// `period` is never reached and leaves the output high.
fn compare(duty: i16, period: u32) -> (u16, u16) {
    let driven = (u32::from(duty.unsigned_abs()) * period) >> 15;
    let braked = period.saturating_sub(driven) as u16;
    if duty >= 0 {
        (period as u16, braked)
    } else {
        (braked, period as u16)
    }
}

struct Motor {
    /// Keeps the slice and its pins.
    _pwm: Pwm<'static>,
    slice: usize,
    period: u32,
}

impl Motor {
    /// Both inputs in one write, which the PWM takes over at the end of its period: no edge of a reversal is ever
    /// seen half.
    fn set(&mut self, (in1, in2): (u16, u16)) {
        pac::PWM.ch(self.slice).cc().write(|w| {
            w.set_a(in1);
            w.set_b(in2);
        });
    }

    fn drive(&mut self, duty: i16) {
        self.set(compare(duty, self.period));
    }
}

/// Both motors; asleep until first driven.
pub struct Motors {
    left: Motor,
    right: Motor,
    standby: Output<'static>,
}

impl Motors {
    pub fn new(pins: MotorPins) -> Self {
        let period = clk_sys_freq() / FREQUENCY_HZ;
        let mut config = Config::default();
        config.top = (period - 1) as u16;
        Self {
            left: Motor {
                _pwm: Pwm::new_output_ab(
                    pins.left_slice,
                    pins.left_in1,
                    pins.left_in2,
                    config.clone(),
                ),
                slice: LEFT,
                period,
            },
            right: Motor {
                _pwm: Pwm::new_output_ab(pins.right_slice, pins.right_in1, pins.right_in2, config),
                slice: RIGHT,
                period,
            },
            standby: pins.standby,
        }
    }

    /// Duties in Q15, positive forwards.
    pub fn drive(&mut self, left: i16, right: i16) {
        self.left.drive(left);
        self.right.drive(right);
        self.standby.set_high();
        // The edge may have come while this tick was on its way here.
        if emergency::active() {
            emergency::cut();
        }
    }

    /// No torque at all: the wheels turn freely.
    pub fn coast(&mut self) {
        self.standby.set_low();
        self.left.set((0, 0));
        self.right.set((0, 0));
    }
}
