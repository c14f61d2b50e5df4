//! A 2S Li-ion pack: open-circuit voltage over the charge, internal resistance, discharge.

use crate::config;

/// Open-circuit voltage of two cells over the state of charge.
const OPEN_CIRCUIT: [(f64, f64); 7] = [
    (0.0, 5.6),
    (0.05, 6.5),
    (0.1, 6.9),
    (0.25, 7.2),
    (0.5, 7.4),
    (0.75, 7.8),
    (1.0, 8.4),
];

pub struct Battery {
    config: config::Battery,
    charge: f64,
    voltage: f64,
}

impl Battery {
    pub fn new(config: &config::Battery) -> Self {
        let mut battery = Self {
            config: config.clone(),
            charge: config.state_of_charge,
            voltage: 0.0,
        };
        battery.step(0.0, 0.0, 0.0);
        battery
    }

    /// Terminal voltage, volts.
    pub fn voltage(&self) -> f64 {
        self.voltage
    }

    /// State of charge, 0 to 1.
    pub fn charge(&self) -> f64 {
        self.charge
    }

    pub fn set_charge(&mut self, charge: f64) {
        self.charge = charge.clamp(0.0, 1.0);
    }

    /// Draws the motors' current (A) for `dt` seconds; `voltage_drop`: lost to a fault. What braking motors feed back is not stored.
    pub fn step(&mut self, motor_current: f64, voltage_drop: f64, dt: f64) {
        let current = motor_current.max(0.0) + self.config.base_current;
        self.charge = (self.charge - current * dt / (3600.0 * self.config.capacity_ah)).max(0.0);
        self.voltage =
            (open_circuit(self.charge) - current * self.config.internal_resistance - voltage_drop)
                .max(0.0);
    }
}

fn open_circuit(charge: f64) -> f64 {
    let charge = charge.clamp(0.0, 1.0);
    OPEN_CIRCUIT
        .windows(2)
        .find(|pair| charge <= pair[1].0)
        .map_or(OPEN_CIRCUIT[OPEN_CIRCUIT.len() - 1].1, |pair| {
            let ((low, start), (high, end)) = (pair[0], pair[1]);
            start + (end - start) * (charge - low) / (high - low)
        })
}
