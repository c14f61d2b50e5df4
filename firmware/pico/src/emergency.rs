//! The emergency-stop input, faster than the control loop: its edge puts the H-bridge to sleep at once.
//!
//! The core sees the level at its next tick and latches. Until then the bridge sleeps; a spike that is gone by the
//! next tick only costs that millisecond of torque.

use embassy_rp::gpio::Input;
use embassy_rp::pac;

use crate::crash::{self, task};
use crate::pins::{EMERGENCY_STOP_MASK, STANDBY_MASK};

/// The input's level now. The switch is normally closed to ground: high means pressed, or a broken wire.
pub fn active() -> bool {
    pac::SIO.gpio_in(0).read() & EMERGENCY_STOP_MASK != 0
}

/// Pull STBY low, whatever else goes on.
pub fn cut() {
    pac::SIO.gpio_out(0).value_clr().write_value(STANDBY_MASK);
}

#[embassy_executor::task]
pub async fn run(switch: Input<'static>) {
    crash::within(task::EMERGENCY_STOP, watch(switch)).await
}

async fn watch(mut switch: Input<'static>) {
    loop {
        switch.wait_for_high().await;
        cut();
        switch.wait_for_low().await;
    }
}
