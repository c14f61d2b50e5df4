//! TB6612FNG with PWMA and PWMB tied high: two inputs a motor, STBY takes the power off.

use super::{slow_decay, Bridge};

pub const BRIDGE: Bridge = Bridge {
    max_pwm_hz: 100_000,
    compare: slow_decay,
};
