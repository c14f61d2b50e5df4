//! Two DC motors on a TB6612FNG: direction on IN1 and IN2, duty on PWM, both asleep through STBY.
//!
//! IN1 and IN2 low let a motor coast; with a direction set, the low part of the PWM brakes it, which makes the speed
//! nearly proportional to the duty.

use embassy_rp::clocks::clk_sys_freq;
use embassy_rp::gpio::Output;
use embassy_rp::pwm::{Config, Pwm, PwmOutput, SetDutyCycle};

use crate::emergency;
use crate::pins::MotorPins;

/// Above hearing, far below the bridge's 100 kHz.
const FREQUENCY_HZ: u32 = 20_000;

struct Motor {
    pwm: PwmOutput<'static>,
    in1: Output<'static>,
    in2: Output<'static>,
    top: u16,
}

impl Motor {
    /// `duty` in Q15, positive forwards.
    fn drive(&mut self, duty: i16) {
        let compare = (u32::from(duty.unsigned_abs()) * u32::from(self.top)) >> 15;
        // Cannot fail: |duty| is at most 1.0, so compare is at most top.
        let _ = self.pwm.set_duty_cycle(compare as u16);
        self.in1.set_level((duty >= 0).into());
        self.in2.set_level((duty < 0).into());
    }

    fn coast(&mut self) {
        self.in1.set_low();
        self.in2.set_low();
        let _ = self.pwm.set_duty_cycle(0);
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
        let top = (clk_sys_freq() / FREQUENCY_HZ - 1) as u16;
        let mut config = Config::default();
        config.top = top;
        let pwm = Pwm::new_output_ab(pins.slice, pins.left_pwm, pins.right_pwm, config);
        let (Some(left), Some(right)) = pwm.split() else {
            unreachable!("the slice was made with both outputs")
        };
        Self {
            left: Motor {
                pwm: left,
                in1: pins.left_in1,
                in2: pins.left_in2,
                top,
            },
            right: Motor {
                pwm: right,
                in1: pins.right_in1,
                in2: pins.right_in2,
                top,
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
        self.left.coast();
        self.right.coast();
    }
}
