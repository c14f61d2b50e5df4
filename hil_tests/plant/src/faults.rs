//! Faults of the rover's parts that a scenario puts in while the world runs: what breaks is set here by name, and the
//! parts ask for it where they compute what the fault changes.

/// What is broken now. The default is a sound rover.
#[derive(Clone, Debug, Default)]
pub struct Faults {
    /// Left and right.
    pub wheels: [WheelFault; 2],
    /// The plugs of both encoders are in each other's sockets.
    pub encoders_swapped: bool,
    /// Left, centre, right.
    pub sonars: [Option<SonarFault>; 3],
    /// Taken off the battery's terminal voltage, volts.
    pub voltage_drop: f64,
    /// No wheel touches the ground.
    pub lifted: bool,
    /// What tilts the rover beyond the ground: roll and pitch, radians.
    pub tilt: [f64; 2],
    /// A switch of the bumper is held closed.
    pub bumper_pressed: bool,
    /// Of the inertial sensor.
    pub inertial: Option<InertialFault>,
    /// Of the thermal camera.
    pub camera: Option<CameraFault>,
}

/// What is broken at one wheel.
#[derive(Clone, Copy, Debug, Default)]
pub struct WheelFault {
    /// The encoder gives no edges; those are lost for good.
    pub encoder_stuck: bool,
    /// Phases A and B are exchanged: it counts backwards.
    pub encoder_reversed: bool,
    /// Part of the wheel's travel that the ground does not get.
    pub slip: f64,
    /// The shaft is jammed.
    pub stalled: bool,
    /// A motor wire is off.
    pub open: bool,
}

/// What is wrong with one sonar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SonarFault {
    /// The sensor says nothing, not even a timeout.
    Dead,
    /// It always hears an echo from this range, metres.
    Near(f64),
    /// It never hears an echo.
    Deaf,
}

/// What is wrong with the inertial sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InertialFault {
    /// It acknowledges nothing.
    Silent,
    /// It shows the same for ever.
    Frozen,
    /// It holds the bus's data line low.
    HoldsBus,
}

/// What is wrong with the camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CameraFault {
    /// New frames with the old picture.
    Frozen,
    /// No frames.
    Dead,
    /// The shutter is closed for a calibration.
    Calibrating,
}

impl Faults {
    /// Sets one fault. `index`: wheel (0 left, 1 right) or sonar (0 to 2), 0 otherwise; `value`: its size where it has
    /// one, else anything but 0 puts it in; 0 takes it away. The error says what is wrong.
    pub fn set(&mut self, name: &str, index: usize, value: f64) -> Result<(), String> {
        let on = value != 0.0;
        if let Some(camera) = camera_fault(name) {
            self.camera = on.then_some(camera);
            return Ok(());
        }
        if let Some(inertial) = inertial_fault(name) {
            self.inertial = on.then_some(inertial);
            return Ok(());
        }
        match name {
            "bumper-pressed" => self.bumper_pressed = on,
            "lifted" => self.lifted = on,
            "rolled" => self.tilt[0] = value,
            "pitched" => self.tilt[1] = value,
            "encoders-swapped" => self.encoders_swapped = on,
            "voltage-drop" => self.voltage_drop = value,
            "sonar-dead" => *self.sonar(index)? = on.then_some(SonarFault::Dead),
            "sonar-near" => *self.sonar(index)? = on.then_some(SonarFault::Near(value)),
            "sonar-deaf" => *self.sonar(index)? = on.then_some(SonarFault::Deaf),
            "encoder-stuck" => self.wheel(index)?.encoder_stuck = on,
            "encoder-reversed" => self.wheel(index)?.encoder_reversed = on,
            "wheel-slip" => self.wheel(index)?.slip = value,
            "motor-stalled" => self.wheel(index)?.stalled = on,
            "motor-open" => self.wheel(index)?.open = on,
            _ => return Err(format!("fault {name}: the plant does not know it")),
        }
        Ok(())
    }

    /// Steps of the encoders as the firmware gets them, from those that the wheels have made.
    pub fn encoder_steps(&self, steps: [i32; 2]) -> [i32; 2] {
        let [left, right] = steps;
        let plugged = if self.encoders_swapped {
            [right, left]
        } else {
            [left, right]
        };
        std::array::from_fn(|wheel| match self.wheels[wheel] {
            fault if fault.encoder_stuck => 0,
            fault if fault.encoder_reversed => -plugged[wheel],
            _ => plugged[wheel],
        })
    }

    fn wheel(&mut self, index: usize) -> Result<&mut WheelFault, String> {
        self.wheels
            .get_mut(index)
            .ok_or_else(|| format!("wheel {index}: there are two, 0 and 1"))
    }

    fn sonar(&mut self, index: usize) -> Result<&mut Option<SonarFault>, String> {
        self.sonars
            .get_mut(index)
            .ok_or_else(|| format!("sonar {index}: there are three, 0 to 2"))
    }
}

fn inertial_fault(name: &str) -> Option<InertialFault> {
    Some(match name {
        "inertial-silent" => InertialFault::Silent,
        "inertial-frozen" => InertialFault::Frozen,
        "inertial-holds-bus" => InertialFault::HoldsBus,
        _ => return None,
    })
}

fn camera_fault(name: &str) -> Option<CameraFault> {
    Some(match name {
        "camera-frozen" => CameraFault::Frozen,
        "camera-dead" => CameraFault::Dead,
        "camera-ffc" => CameraFault::Calibrating,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_fault_comes_and_goes_by_its_name() {
        let names = [
            "lifted",
            "rolled",
            "pitched",
            "encoders-swapped",
            "voltage-drop",
            "sonar-dead",
            "sonar-near",
            "sonar-deaf",
            "encoder-stuck",
            "encoder-reversed",
            "wheel-slip",
            "motor-stalled",
            "motor-open",
            "inertial-silent",
            "inertial-frozen",
            "inertial-holds-bus",
            "camera-frozen",
            "camera-dead",
            "camera-ffc",
        ];
        let sound = format!("{:?}", Faults::default());
        for name in names {
            let mut faults = Faults::default();
            faults.set(name, 1, 0.5).unwrap();
            assert_ne!(format!("{faults:?}"), sound, "{name} changes something");
            faults.set(name, 1, 0.0).unwrap();
            assert_eq!(format!("{faults:?}"), sound, "{name} goes again");
        }
    }

    #[test]
    fn what_does_not_exist_is_said() {
        let mut faults = Faults::default();
        assert!(faults
            .set("wheel-lost", 0, 1.0)
            .unwrap_err()
            .contains("wheel-lost"));
        assert!(faults
            .set("motor-open", 2, 1.0)
            .unwrap_err()
            .contains("two, 0 and 1"));
        assert!(faults
            .set("sonar-dead", 3, 1.0)
            .unwrap_err()
            .contains("three, 0 to 2"));
    }

    #[test]
    fn an_encoder_is_swapped_before_its_own_fault_acts() {
        let mut faults = Faults::default();
        faults.set("encoders-swapped", 0, 1.0).unwrap();
        assert_eq!(faults.encoder_steps([3, -7]), [-7, 3]);
        faults.set("encoder-reversed", 0, 1.0).unwrap();
        assert_eq!(faults.encoder_steps([3, -7]), [7, 3]);
        faults.set("encoder-stuck", 0, 1.0).unwrap();
        assert_eq!(faults.encoder_steps([3, -7]), [0, 3]);
    }
}
