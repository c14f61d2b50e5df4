//! Test mode: what the pins would measure comes over the link, and the bridges stay off whatever the controller wants.
//!
//! For rigs that have a real board and no rover around it. It can only be entered and left while the motors are off;
//! an injector that falls silent ends it, and the rover latches. The real emergency stop counts at all times.

use rover_protocol::messages as m;

use crate::battery::Battery;
use crate::controller::Core;
use crate::injection::Injection;
use crate::io::{Inputs, Outputs};
use crate::sonar::Sonar;
use crate::supervisor::{Event, State};

const KEY: u16 = 0x5445;
const BEGIN: u8 = 1;
const END: u8 = 0;

impl Core {
    /// Begin or end; what is not allowed now changes nothing. State answers.
    pub(crate) fn test_mode(&mut self, wanted: &m::TestMode, now_us: u64) -> Option<()> {
        let idle = matches!(self.supervisor.state(), State::Disarmed | State::Latched);
        match wanted.enable {
            BEGIN if wanted.key != KEY => return None,
            BEGIN if idle && self.session.is_some() && self.injection.is_none() => {
                let battery_mv = self.battery.voltage_mv();
                self.forget_measurements();
                self.injection = Some(Injection::new(battery_mv, now_us));
            }
            END if idle && self.injection.is_some() => self.leave_test_mode(),
            BEGIN | END => {}
            _ => return None,
        }
        let state = self.state_message();
        self.link.send_urgent(&state);
        Some(())
    }

    /// None outside test mode.
    pub(crate) fn inject_wheels(&mut self, wheels: &m::InjectWheels, now_us: u64) -> Option<()> {
        let injection = self.injection.as_mut()?;
        injection.heard_us = now_us;
        if injection
            .counts
            .replace([wheels.left, wheels.right])
            .is_none()
        {
            self.odometry.rebase();
        }
        Some(())
    }

    /// None outside test mode.
    pub(crate) fn inject_sensors(&mut self, sensors: &m::InjectSensors, now_us: u64) -> Option<()> {
        let injection = self.injection.as_mut()?;
        injection.heard_us = now_us;
        injection.battery_mv = sensors.battery;
        injection.emergency_stop = sensors.emergency_stop != 0;
        injection.bumper = sensors.bumper != 0;
        if let Some(echo_us) = injection.echoes_us.get_mut(usize::from(sensors.sonar)) {
            *echo_us = sensors.echo;
        }
        Some(())
    }

    /// What this tick goes by: the board's measurements, or those of the injector.
    pub(crate) fn measurements(&mut self, inputs: &Inputs) -> Inputs {
        let patience_us = self.settings.dead_man_us;
        let silent =
            |injection: &Injection| self.now_us.saturating_sub(injection.heard_us) > patience_us;
        if self.injection.as_ref().is_some_and(silent) {
            self.leave_test_mode();
            self.raise(Event::InjectorSilent, 0);
        }
        let Some(injection) = &mut self.injection else {
            return *inputs;
        };
        let [encoder_left, encoder_right] = injection.counts.unwrap_or_default();
        Inputs {
            now_us: inputs.now_us,
            began_us: inputs.began_us,
            encoder_left,
            encoder_right,
            battery_mv: injection.battery_mv,
            emergency_stop: inputs.emergency_stop || injection.emergency_stop,
            bumper: injection.bumper,
            sonar: injection.answer(self.now_us),
            // The board's own moves with the board, and nothing injects another.
            inertial: None,
        }
    }

    /// What the board is told: in test mode nothing moves and nothing pings.
    pub(crate) fn withheld(&mut self, outputs: Outputs) -> Outputs {
        let Some(injection) = &mut self.injection else {
            return outputs;
        };
        if let Some(sensor) = outputs.sonar_trigger {
            injection.pinged = Some((sensor, self.now_us));
        }
        Outputs {
            duty_left: 0,
            duty_right: 0,
            powered: false,
            sonar_trigger: None,
            ..outputs
        }
    }

    fn leave_test_mode(&mut self) {
        self.injection = None;
        self.forget_measurements();
    }

    /// The world is another one now: filters begin anew, and a jump of the counts is no way.
    fn forget_measurements(&mut self) {
        self.odometry.rebase();
        self.battery = Battery::default();
        self.sonar = Sonar::default();
    }
}
