//! What the core makes of a tick's measurements, and what of them may end a drive.

use rover_protocol::messages::fault_code;

use crate::controller::Core;
use crate::inertial::WheelMotion;
use crate::io::Inputs;
use crate::sensor_loss::forbids_speed;
use crate::supervisor::{Event, State};

impl Core {
    /// Measurements: battery, encoders, sonar. Returns the encoders' steps and the sensor to ping.
    pub(crate) fn sense(&mut self, inputs: &Inputs) -> ([i32; 2], Option<u8>) {
        let settings = &self.settings;
        self.battery.tick(
            self.now_us,
            inputs.battery_mv,
            settings.low_voltage_mv,
            settings.low_voltage_delay_us,
        );
        let counts = [inputs.encoder_left, inputs.encoder_right];
        let steps = self.odometry.update(counts, &settings.geometry);
        for (wheel, way_nm) in self.wheels.iter_mut().zip(self.odometry.way_nm()) {
            wheel.measure(way_nm);
        }
        let (trigger, ranging) = self.sonar.tick(
            self.now_us,
            inputs.sonar,
            settings.sonar_slot_us,
            settings.sound_speed,
        );
        if let Some(ranging) = ranging {
            self.report_ranging(&ranging);
        }
        self.sense_inertial(inputs);
        (steps, trigger)
    }

    fn sense_inertial(&mut self, inputs: &Inputs) {
        // Three ticks of four bring none.
        let motion = match inputs.inertial {
            Some(_) => self.wheel_motion(),
            None => WheelMotion::default(),
        };
        self.inertial.tick(self.now_us, inputs.inertial, &motion);
        let loss = self.inertial.loss();
        let why = loss.map_or(0, |loss| loss as u32);
        self.faults
            .set(fault_code::INERTIAL_LOST, loss.is_some(), why);
    }

    fn wheel_motion(&self) -> WheelMotion {
        let reference = self.motion.reference();
        let commanded = !(reference.travel.at_rest() && reference.heading.at_rest());
        WheelMotion {
            resting: !commanded && self.is_standing(),
            velocity: reference.travel.quick_velocity(),
            acceleration: reference.travel.quick_acceleration(),
        }
    }

    /// Everything that may end a drive, apart from the drive itself.
    pub(crate) fn watch(&mut self, inputs: &Inputs) {
        self.emergency_input = inputs.emergency_stop;
        if inputs.emergency_stop {
            self.raise(Event::EmergencyInput, 0);
        }
        let travel = self.motion.reference().travel.velocity_micro();
        self.bumper.sense(inputs.bumper, travel);
        if self.bumper.is_touch() && self.supervisor.is_powered() {
            self.raise(Event::Bumper, 0);
            self.bumper.arrest(self.now_us);
        }
        let low = self.battery.is_low();
        let voltage = u32::from(self.battery.voltage_mv());
        self.faults.set(fault_code::LOW_BATTERY, low, voltage);
        if low {
            self.raise(Event::LowBattery, 0);
        }
        let lost = self.lost_sensors();
        let first = lost.trailing_zeros() & 3;
        self.faults.set(fault_code::SONAR_DEAD, lost != 0, first);
        if !self.supervisor.accepts_motion() {
            return;
        }
        if self.now_us.saturating_sub(self.fed_us) > self.settings.dead_man_us {
            self.faults.raise(fault_code::DEAD_MAN, 0);
            self.raise(Event::DeadMan, 0);
        }
        if self.supervisor.state() != State::Moving {
            return;
        }
        let velocity = self.motion.reference().travel.velocity_above();
        if let Some(sensor) = forbids_speed(lost, velocity) {
            self.raise(Event::SensorLost, sensor);
            return;
        }
        if let Some(sensor) = self.settings.guard.too_near(&self.sonar, velocity) {
            let range = u32::from(self.sonar.range_mm(usize::from(sensor)));
            let detail = range << 8 | u32::from(sensor);
            self.faults.raise(fault_code::SONAR_GUARD, detail);
            self.raise(Event::SonarGuard, sensor);
        }
    }

    /// A bit for each sensor that no longer answers and that driving needs.
    pub(crate) fn lost_sensors(&self) -> u8 {
        self.sonar.dead() & self.settings.sonars_needed
    }
}
