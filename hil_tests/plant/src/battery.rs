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

/// The pack and how full it is.
pub struct Battery {
    config: config::Battery,
    charge: f64,
    voltage: f64,
}

impl Battery {
    /// A pack that has stood idle.
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

    /// Sets the state of charge, 0 to 1.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_open_circuit_voltage_goes_through_its_points_and_never_falls_with_the_charge() {
        for (charge, voltage) in OPEN_CIRCUIT {
            assert!((open_circuit(charge) - voltage).abs() < 1e-12);
        }
        let steps: Vec<f64> = (0..=1000)
            .map(|i| open_circuit(f64::from(i) / 1000.0))
            .collect();
        assert!(steps.windows(2).all(|pair| pair[0] <= pair[1]));
        assert_eq!((open_circuit(-1.0), open_circuit(2.0)), (5.6, 8.4));
    }

    #[test]
    fn an_hour_at_one_ampere_takes_an_ampere_hour() {
        let config = config::Battery {
            capacity_ah: 2.0,
            state_of_charge: 1.0,
            base_current: 0.0,
            ..Default::default()
        };
        let mut battery = Battery::new(&config);
        for _ in 0..3600 {
            battery.step(1.0, 0.0, 1.0);
        }
        assert!((battery.charge() - 0.5).abs() < 1e-9);
    }

    #[test]
    fn current_and_faults_lower_the_terminal_voltage_and_braking_does_not_raise_it() {
        let mut battery = Battery::new(&config::Battery::default());
        let idle = battery.voltage();
        battery.step(-3.0, 0.0, 0.0);
        assert_eq!(battery.voltage(), idle);
        battery.step(2.0, 0.0, 0.0);
        assert!(
            (idle - battery.voltage() - 2.0 * config::Battery::default().internal_resistance).abs()
                < 1e-9
        );
        battery.step(0.0, 100.0, 0.0);
        assert_eq!(battery.voltage(), 0.0);
    }
}
