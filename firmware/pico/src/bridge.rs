//! The motor driver boards. A board is one file in `bridge/` and its lines here.

mod drv8833;
mod tb6612;

/// What a driver board wants at the two pins of a motor. Both are channels of one PWM slice.
pub struct Bridge {
    /// The fastest PWM that its inputs take.
    pub max_pwm_hz: u32,
    /// Compare values of IN1 and IN2 for a duty in Q15, positive forwards, of a PWM with `period` steps. A compare value
    /// of `period` is never reached and leaves the output high, 0 leaves it low. Duty 0 brakes.
    pub compare: fn(duty: i16, period: u32) -> (u16, u16),
}

/// Every board that is known.
const KNOWN: [&Bridge; 2] = [&tb6612::BRIDGE, &drv8833::BRIDGE];

/// The one on this rover.
pub const FITTED: &Bridge = &tb6612::BRIDGE;

/// Above hearing.
pub const PWM_HZ: u32 = 20_000;

const _: () = {
    let mut at = 0;
    while at < KNOWN.len() {
        assert!(PWM_HZ <= KNOWN[at].max_pwm_hz);
        at += 1;
    }
};

/// For bridges with two inputs a motor. Slow decay: one input is high and the other carries the inverted PWM, so the
/// bridge brakes in the part of each period in which it does not drive. That makes the speed nearly proportional to the
/// duty. Duty 0 is both inputs high, the brake.
fn slow_decay(duty: i16, period: u32) -> (u16, u16) {
    let driven = (u32::from(duty.unsigned_abs()) * period) >> 15;
    let braked = period.saturating_sub(driven) as u16;
    if duty >= 0 {
        (period as u16, braked)
    } else {
        (braked, period as u16)
    }
}
