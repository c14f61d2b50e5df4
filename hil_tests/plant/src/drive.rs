//! Two geared DC motors that share one chassis, and the slip between wheel and ground.
//!
//! At the wheel shaft, with K the motor constant: i = (u V - K w) / R, torque = K i - viscous w - Coulomb sign(w).
//! The winding's inductance (below 1 ms) is left out. The chassis couples the wheels: its mass and yaw inertia seen
//! from the two shafts are the matrix [[a, b], [b, a]].

use crate::config;
use crate::faults::Faults;
use crate::random::Random;
use crate::slip_bursts::SlipBursts;

/// What the H-bridges do: duty -1..1 of the supply, or open (coast).
#[derive(Clone, Copy, Default)]
pub struct Bridge {
    /// Of the left and the right motor, -1 to 1.
    pub duty: [f64; 2],
    /// False: both bridges are open.
    pub powered: bool,
}

/// Both wheels with their motors and encoders.
pub struct Drive {
    config: config::Drive,
    random: Random,
    resistance: [f64; 2],
    back_emf: [f64; 2],
    slip_bias: [f64; 2],
    slip_noise: [f64; 2],
    bursts: SlipBursts,
    inertia: (f64, f64),
    /// Shaft speeds, rad/s, and angles, rad.
    speed: [f64; 2],
    angle: [f64; 2],
    /// Encoder counts, and those that sound encoders would show.
    counts: [i32; 2],
    turned: [i32; 2],
    current: f64,
}

impl Drive {
    /// Standing wheels; `seed` draws what tells one motor and wheel from the other.
    pub fn new(config: &config::Drive, seed: u64) -> Self {
        let mut random = Random::stream(seed, "drive");
        let mut spread = |nominal: f64| nominal * (1.0 + random.symmetric(config.motor_tolerance));
        let resistance = [spread(config.resistance), spread(config.resistance)];
        let back_emf = [spread(config.back_emf), spread(config.back_emf)];
        let limit = config.slip_bias_limit.abs();
        let mut bias = || (random.normal() * config.slip_bias).clamp(-limit, limit);
        let slip_bias = [bias(), bias()];
        let square = config.wheel_radius * config.wheel_radius;
        let translation = config.mass * square / 4.0;
        let rotation = config.yaw_inertia * square / (config.track_width * config.track_width);
        Self {
            config: config.clone(),
            random,
            resistance,
            back_emf,
            slip_bias,
            slip_noise: [0.0; 2],
            bursts: SlipBursts::new(&config.slip_bursts, seed),
            inertia: (
                config.rotor_inertia + translation + rotation,
                translation - rotation,
            ),
            speed: [0.0; 2],
            angle: [0.0; 2],
            counts: [0; 2],
            turned: [0; 2],
            current: 0.0,
        }
    }

    /// Shaft angles (left, right), radians, since the start.
    pub fn angle(&self) -> [f64; 2] {
        self.angle
    }

    /// Wheel surface speeds (left, right), m/s.
    pub fn surface_speed(&self) -> [f64; 2] {
        self.speed.map(|speed| speed * self.config.wheel_radius)
    }

    /// Slip fractions (left, right) of this moment: ground travel = surface travel × (1 - slip).
    pub fn slip(&self) -> [f64; 2] {
        std::array::from_fn(|wheel| self.slip_bias[wheel] + self.slip_noise[wheel])
    }

    /// Current drawn from the battery in the last step, A.
    pub fn supply_current(&self) -> f64 {
        self.current
    }

    /// x4 quadrature counts (left, right).
    pub fn counts(&self) -> [i32; 2] {
        self.counts
    }

    /// Makes an encoder jump, as a burst of interference does.
    pub fn kick_encoder(&mut self, wheel: usize, counts: i32) {
        self.counts[wheel] = self.counts[wheel].wrapping_add(counts);
    }

    /// Lets the encoders count what the wheels have turned since the last step.
    fn count(&mut self, faults: &Faults) {
        let scale = self.config.counts_per_revolution / std::f64::consts::TAU;
        let turned = self
            .angle
            .map(|angle| (angle * scale).floor() as i64 as i32);
        let steps = std::array::from_fn(|wheel| turned[wheel].wrapping_sub(self.turned[wheel]));
        self.turned = turned;
        for (count, step) in self.counts.iter_mut().zip(faults.encoder_steps(steps)) {
            *count = count.wrapping_add(step);
        }
    }

    /// One step of `dt` seconds at `voltage`; `blocked` adds the torque of wheels that spin on the spot.
    /// Returns the ground travel of both wheels in metres.
    pub fn step(
        &mut self,
        bridge: Bridge,
        voltage: f64,
        blocked: bool,
        faults: &Faults,
        dt: f64,
    ) -> [f64; 2] {
        self.current = 0.0;
        let mut motor_torque = |wheel: usize| {
            let mut torque = -self.config.viscous_friction * self.speed[wheel];
            if bridge.powered && !faults.wheels[wheel].open {
                let duty = bridge.duty[wheel];
                let emf = self.back_emf[wheel] * self.speed[wheel];
                let current = (duty * voltage - emf) / self.resistance[wheel];
                torque += self.back_emf[wheel] * current;
                self.current += duty * current;
            }
            torque
        };
        let torque = [motor_torque(0), motor_torque(1)];
        let holding = self.config.coulomb_friction
            + if blocked {
                self.config.traction_torque
            } else {
                0.0
            };
        let before = self.speed;
        self.speed = self.rub(torque, holding, dt);
        for (speed, wheel) in self.speed.iter_mut().zip(&faults.wheels) {
            if wheel.stalled {
                *speed = 0.0;
            }
        }
        self.vary_slip(dt);
        let slip: [f64; 2] =
            std::array::from_fn(|wheel| self.slip()[wheel] + faults.wheels[wheel].slip);
        let travel = std::array::from_fn(|wheel| {
            let turned = 0.5 * (before[wheel] + self.speed[wheel]) * dt;
            self.angle[wheel] += turned;
            let radius = self.config.wheel_radius * self.config.wheel_radius_ratio[wheel];
            let surface = turned * radius;
            if faults.lifted {
                return 0.0;
            }
            surface * (1.0 - slip[wheel] - self.bursts.slip(wheel, surface))
        });
        self.count(faults);
        travel
    }

    /// Speeds after `dt` with the motors' torques and a Coulomb friction of up to `holding`, which slows a wheel down
    /// or holds it, and never reverses it. Both frictions are found together by projected Gauss-Seidel sweeps, which
    /// converge fast because the wheels are weakly coupled.
    fn rub(&self, torque: [f64; 2], holding: f64, dt: f64) -> [f64; 2] {
        const SWEEPS: usize = 4;
        let (a, b) = self.inertia;
        let determinant = a * a - b * b;
        let (own, other) = (a / determinant * dt, -b / determinant * dt);
        let after = |wheel: usize, friction: [f64; 2]| {
            let push = |w: usize| torque[w] + friction[w];
            self.speed[wheel] + own * push(wheel) + other * push(1 - wheel)
        };
        let mut friction = [0.0; 2];
        for _ in 0..SWEEPS {
            for wheel in 0..2 {
                let stopping = friction[wheel] - after(wheel, friction) / own;
                friction[wheel] = stopping.clamp(-holding, holding);
            }
        }
        // Friction that is not used up holds the wheel: exactly still, not still up to the last sweep.
        std::array::from_fn(|wheel| {
            let holds = friction[wheel].abs() < holding;
            if holds {
                0.0
            } else {
                after(wheel, friction)
            }
        })
    }

    /// Ornstein-Uhlenbeck process of the configured standard deviation and correlation time.
    fn vary_slip(&mut self, dt: f64) {
        let decay = dt / self.config.slip_time_constant;
        let kick = self.config.slip_noise * (2.0 * decay).sqrt();
        for noise in &mut self.slip_noise {
            *noise += -decay * *noise + kick * f64::from(self.random.quick_normal());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DT: f64 = 1e-3;
    const SUPPLY: f64 = 7.4;

    /// A rover whose motors are alike and whose wheels do not slip.
    fn exact() -> config::Drive {
        config::Drive {
            motor_tolerance: 0.0,
            slip_bias: 0.0,
            slip_noise: 0.0,
            ..Default::default()
        }
    }

    fn run(drive: &mut Drive, duty: [f64; 2], faults: &Faults, steps: usize) -> [f64; 2] {
        let mut way = [0.0; 2];
        for _ in 0..steps {
            let bridge = Bridge {
                duty,
                powered: true,
            };
            let travel = drive.step(bridge, SUPPLY, false, faults, DT);
            way = [way[0] + travel[0], way[1] + travel[1]];
        }
        way
    }

    #[test]
    fn the_steady_speed_is_where_the_motors_torque_equals_friction() {
        let config = exact();
        let mut drive = Drive::new(&config, 1);
        run(&mut drive, [0.5, 0.5], &Faults::default(), 5000);
        let speed = drive.surface_speed()[0] / config.wheel_radius;
        let current = (0.5 * SUPPLY - config.back_emf * speed) / config.resistance;
        let torque = config.back_emf * current - config.viscous_friction * speed;
        assert!((torque - config.coulomb_friction).abs() < 1e-6, "{torque}");
    }

    #[test]
    fn a_duty_below_static_friction_moves_nothing_at_all() {
        let config = exact();
        let needed = config.coulomb_friction / config.back_emf * config.resistance / SUPPLY;
        let mut drive = Drive::new(&config, 1);
        assert_eq!(
            run(&mut drive, [0.99 * needed; 2], &Faults::default(), 1000),
            [0.0; 2]
        );
        assert!(run(&mut drive, [1.05 * needed; 2], &Faults::default(), 1000)[0] > 0.0);
    }

    #[test]
    fn open_bridges_let_the_wheels_roll_out() {
        let mut drive = Drive::new(&exact(), 1);
        run(&mut drive, [0.6, 0.6], &Faults::default(), 1000);
        let mut steps = 0;
        while drive.surface_speed() != [0.0; 2] {
            drive.step(Bridge::default(), SUPPLY, false, &Faults::default(), DT);
            steps += 1;
            assert!(steps < 5000, "friction must stop it");
        }
        assert_eq!(drive.supply_current(), 0.0);
        assert!(steps > 50, "and not at once: {steps} ms");
    }

    #[test]
    fn counts_follow_the_shaft_and_a_stuck_encoder_loses_them_for_good() {
        let config = exact();
        let mut drive = Drive::new(&config, 1);
        let mut faults = Faults::default();
        run(&mut drive, [0.5, 0.5], &faults, 500);
        let turned = drive.angle()[1] / std::f64::consts::TAU * config.counts_per_revolution;
        assert_eq!(drive.counts()[1], turned.floor() as i32);
        faults.set("encoder-stuck", 0, 1.0).unwrap();
        let before = drive.counts()[0];
        run(&mut drive, [0.5, 0.5], &faults, 500);
        assert_eq!(drive.counts()[0], before);
        faults.set("encoder-stuck", 0, 0.0).unwrap();
        run(&mut drive, [0.5, 0.5], &faults, 500);
        assert!(drive.counts()[0] > before && drive.counts()[0] < drive.counts()[1]);
    }

    #[test]
    fn a_smaller_wheel_comes_less_far_with_the_same_turns() {
        let config = config::Drive {
            wheel_radius_ratio: [1.0, 0.98],
            ..exact()
        };
        let mut drive = Drive::new(&config, 1);
        let [left, right] = run(&mut drive, [0.5, 0.5], &Faults::default(), 1000);
        assert!((right / left - 0.98).abs() < 1e-12, "{left} {right}");
    }

    #[test]
    fn one_seed_gives_one_rover() {
        let config = config::Drive::default();
        let drive = |seed| {
            let mut drive = Drive::new(&config, seed);
            run(&mut drive, [0.4, 0.5], &Faults::default(), 300)
        };
        assert_eq!(drive(5), drive(5));
        assert_ne!(drive(5), drive(6));
    }
}
