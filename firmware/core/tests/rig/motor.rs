//! A geared DC motor with its wheel: first-order lag, Coulomb friction, supply voltage.

/// How the motor behaves at 7.4 V.
#[derive(Clone, Copy, Debug)]
pub struct MotorKind {
    /// Duty that friction takes.
    pub friction: f64,
    /// m/s at full duty.
    pub top_speed: f64,
    /// s.
    pub time_constant: f64,
}

/// The typical small gear motor.
pub const HEAVY: MotorKind = MotorKind {
    friction: 0.10,
    top_speed: 0.45,
    time_constant: 0.06,
};

/// A brisk one with little friction.
pub const LIGHT: MotorKind = MotorKind {
    friction: 0.03,
    top_speed: 0.45,
    time_constant: 0.022,
};

pub struct Motor {
    pub kind: MotorKind,
    /// m and m/s of the wheel's rim.
    pub position: f64,
    pub velocity: f64,
    /// Held fast.
    pub blocked: bool,
    /// The encoder's wire is off.
    pub encoder_dead: bool,
    frozen: i32,
}

impl Motor {
    pub fn new(kind: MotorKind) -> Self {
        Self {
            kind,
            position: 0.0,
            velocity: 0.0,
            blocked: false,
            encoder_dead: false,
            frozen: 0,
        }
    }

    pub fn counts(&self) -> i32 {
        if self.encoder_dead {
            return self.frozen;
        }
        (self.position / 130.899_694e-6).floor() as i32
    }

    /// Cut the encoder's wire now.
    pub fn kill_encoder(&mut self) {
        self.frozen = self.counts();
        self.encoder_dead = true;
    }

    /// One millisecond at a duty (Q15), or coasting.
    pub fn step_1ms(&mut self, duty: Option<i16>, battery_mv: u16) {
        let MotorKind {
            friction,
            top_speed,
            time_constant,
        } = self.kind;
        let gain = top_speed / (1.0 - friction);
        let dt = 1e-4;
        for _ in 0..10 {
            let drive = match duty {
                Some(duty) => {
                    gain * f64::from(duty) / 32_768.0 * f64::from(battery_mv) / 7_400.0
                        - self.velocity
                }
                // Coasting leaves the bearings' drag.
                None => -0.2 * self.velocity,
            };
            let free = self.velocity + drive / time_constant * dt;
            // Friction may stop the wheel within a step, never reverse it.
            let loss = gain * friction / time_constant * dt;
            self.velocity = free.signum() * (free.abs() - loss).max(0.0);
            if self.blocked {
                self.velocity = 0.0;
            }
            self.position += self.velocity * dt;
        }
    }
}
