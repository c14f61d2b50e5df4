//! DRV8833: two inputs a motor, nSLEEP takes the power off.

use super::{slow_decay, Bridge};

pub const BRIDGE: Bridge = Bridge {
    max_pwm_hz: 250_000,
    compare: slow_decay,
};
