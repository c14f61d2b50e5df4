//! Two DC motors on the bridge that is fitted (`bridge.rs`). The standby line lets them coast, and that is how power is
//! taken off.

use embassy_rp::clocks::clk_sys_freq;
use embassy_rp::gpio::Output;
use embassy_rp::pac;
use embassy_rp::pwm::{Config, Pwm};

use crate::bridge::{FITTED, PWM_HZ};
use crate::emergency;
use crate::pins::MotorPins;

/// The slices of [`MotorPins`].
const LEFT: usize = 3;
const RIGHT: usize = 4;

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
        self.set((FITTED.compare)(duty, self.period));
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
        let period = clk_sys_freq() / PWM_HZ;
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
