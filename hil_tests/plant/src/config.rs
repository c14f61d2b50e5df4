//! What the plant is made of: physical constants with the nominal vehicle as default, read from JSON.

use serde::Deserialize;

use crate::bolometer::Bolometer;
use crate::lens::Lens;

/// The whole plant.
#[derive(Clone, Debug, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Fixes everything that is random.
    pub seed: u64,
    /// Lower-left corner of the ground rasters' first cell, metres.
    pub raster_origin_x: f64,
    /// As for x.
    pub raster_origin_y: f64,
    /// Side of a cell of the ground rasters, metres.
    pub raster_resolution: f64,
    /// Size of the area along x, whose bounds are walls, metres.
    pub area_width: f64,
    /// Size of the area along y, metres.
    pub area_height: f64,
    /// Where the rover starts.
    pub launch: Launch,
    /// Chassis, wheels and motors.
    pub drive: Drive,
    /// How the ground tilts the rover; not at all unless said otherwise.
    pub unevenness: Unevenness,
    /// The pack.
    pub battery: Battery,
    /// What is connected otherwise than it should be.
    pub wiring: Wiring,
    /// The ultrasonic sensors.
    pub sonar: Sonar,
    /// The thermal camera.
    pub camera: Camera,
    /// The inertial sensor; none unless said otherwise.
    pub inertial: Inertial,
    /// Bits per second of the serial line; ten bits carry a byte.
    pub baud: u64,
    /// Radius of the footprint disc around base_link, metres.
    pub footprint_radius: f64,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            seed: 0,
            raster_origin_x: 0.0,
            raster_origin_y: 0.0,
            raster_resolution: 0.01,
            area_width: 3.0,
            area_height: 4.0,
            launch: Launch::default(),
            drive: Drive::default(),
            unevenness: Unevenness::default(),
            battery: Battery::default(),
            wiring: Wiring::default(),
            sonar: Sonar::default(),
            camera: Camera::default(),
            inertial: Inertial::default(),
            baud: 230_400,
            footprint_radius: 0.15,
        }
    }
}

/// Pose at time zero, and the disc around it that the operator surveyed.
#[derive(Clone, Debug, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Launch {
    /// Metres.
    pub x: f64,
    /// Metres.
    pub y: f64,
    /// Radians, counter-clockwise from x.
    pub heading: f64,
    /// Radius of the surveyed disc, metres.
    pub surveyed_radius: f64,
}

impl Default for Launch {
    fn default() -> Self {
        Self {
            x: 0.4,
            y: 0.4,
            heading: 0.0,
            surveyed_radius: 0.25,
        }
    }
}

/// Chassis, wheels and motors; motor constants are those at the wheel shaft, behind the 1:30 gear.
#[derive(Clone, Debug, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Drive {
    /// Between the wheels' contact patches, metres.
    pub track_width: f64,
    /// Rolling radius of a wheel, metres.
    pub wheel_radius: f64,
    /// Rolling radius of the left and the right wheel over that.
    pub wheel_radius_ratio: [f64; 2],
    /// x4 quadrature counts of a wheel's turn.
    pub counts_per_revolution: f64,
    /// Of the whole rover, kg.
    pub mass: f64,
    /// About the vertical through base_link, kg m².
    pub yaw_inertia: f64,
    /// Rotor seen through the gear, plus the wheel, kg m².
    pub rotor_inertia: f64,
    /// Of a motor's winding, ohms.
    pub resistance: f64,
    /// V s/rad, and N m/A.
    pub back_emf: f64,
    /// N m: gear, bearings and rolling resistance.
    pub coulomb_friction: f64,
    /// N m s/rad.
    pub viscous_friction: f64,
    /// Motors differ from the nominal one by up to this fraction.
    pub motor_tolerance: f64,
    /// Standard deviation and bound of each wheel's constant slip fraction.
    pub slip_bias: f64,
    /// Bound of the constant slip fraction.
    pub slip_bias_limit: f64,
    /// Standard deviation and correlation time (s) of the slip that varies.
    pub slip_noise: f64,
    /// Correlation time of the slip that varies, s.
    pub slip_time_constant: f64,
    /// Moments without grip; none unless said otherwise.
    pub slip_bursts: SlipBursts,
    /// Torque that a blocked wheel needs to spin on the ground, N m.
    pub traction_torque: f64,
}

impl Default for Drive {
    fn default() -> Self {
        Self {
            track_width: 0.20,
            wheel_radius: 0.0325,
            wheel_radius_ratio: [1.0; 2],
            counts_per_revolution: 1560.0,
            mass: 2.4,
            yaw_inertia: 0.03,
            rotor_inertia: 8.0e-4,
            resistance: 3.0,
            back_emf: 0.5,
            coulomb_friction: 0.04,
            viscous_friction: 0.004,
            motor_tolerance: 0.03,
            slip_bias: 0.01,
            slip_bias_limit: 0.03,
            slip_noise: 0.01,
            slip_time_constant: 3.0,
            slip_bursts: SlipBursts::default(),
            traction_torque: 0.2,
        }
    }
}

/// Bursts of slip, of each wheel by itself.
#[derive(Clone, Debug, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SlipBursts {
    /// Part of all travel that is lost in bursts; 0: there are none.
    pub mean: f64,
    /// Part of its travel that a wheel loses during one.
    pub size: f64,
    /// Mean length of one, metres of the wheel's surface.
    pub length: f64,
}

impl Default for SlipBursts {
    fn default() -> Self {
        Self {
            mean: 0.0,
            size: 0.3,
            length: 0.1,
        }
    }
}

/// Slopes that are too small for the height raster, or too wide: the rover leans, and everything on it.
#[derive(Clone, Debug, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Unevenness {
    /// Root mean square of the angle between the rover's up and the vertical, radians; 0: level ground.
    pub tilt: f64,
    /// Shortest wave of the slope, metres; the longest is three times as long.
    pub length: f64,
}

impl Default for Unevenness {
    fn default() -> Self {
        Self {
            tilt: 0.0,
            length: 1.0,
        }
    }
}

/// How motors, encoders, sonars and the divider are really connected; left and right as the rover has them. Nothing is
/// wrong by default.
#[derive(Clone, Debug, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Wiring {
    /// A motor that turns backward when it is driven forward.
    pub motors_inverted: [bool; 2],
    /// An encoder that counts down when its wheel rolls forward.
    pub encoders_inverted: [bool; 2],
    /// The board's left output drives the right motor, and the other way round.
    pub motors_swapped: bool,
    /// The board's left input reads the right encoder, and the other way round.
    pub encoders_swapped: bool,
    /// A motor without a connection.
    pub motors_dead: [bool; 2],
    /// An encoder without a connection.
    pub encoders_dead: [bool; 2],
    /// The sensor that each of the board's pins, left, centre and right, leads to.
    pub sonars: [u8; 3],
    /// Sensors without a connection.
    pub sonars_dead: [bool; 3],
    /// Voltage that the board reads over the true one.
    pub battery_scale: f64,
}

impl Default for Wiring {
    fn default() -> Self {
        Self {
            motors_inverted: [false; 2],
            encoders_inverted: [false; 2],
            motors_swapped: false,
            encoders_swapped: false,
            motors_dead: [false; 2],
            encoders_dead: [false; 2],
            sonars: [0, 1, 2],
            sonars_dead: [false; 3],
            battery_scale: 1.0,
        }
    }
}

/// Two Li-ion cells in series.
#[derive(Clone, Debug, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Battery {
    /// Capacity, ampere hours.
    pub capacity_ah: f64,
    /// Charge at the start, 0 to 1.
    pub state_of_charge: f64,
    /// Ohms.
    pub internal_resistance: f64,
    /// Companion and electronics, amperes.
    pub base_current: f64,
    /// Standard deviation of the firmware's measurement, volts.
    pub measurement_noise: f64,
}

impl Default for Battery {
    fn default() -> Self {
        Self {
            capacity_ah: 2.6,
            state_of_charge: 0.75,
            internal_resistance: 0.15,
            base_current: 0.9,
            measurement_noise: 0.006,
        }
    }
}

/// Three HC-SR04: (x, y, yaw) on base_link, and what their echoes are like.
#[derive(Clone, Debug, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Sonar {
    /// Left, centre, right: x and y in metres, yaw in radians.
    pub mounts: [[f64; 3]; 3],
    /// Obstacles must be taller than this to echo, metres.
    pub mount_height: f64,
    /// Half the opening angle of the cone, radians.
    pub half_angle: f64,
    /// Nothing is measured as nearer than this, metres.
    pub minimum_range: f64,
    /// Nothing farther echoes, metres.
    pub maximum_range: f64,
    /// Share of echoes that get lost.
    pub dropout: f64,
    /// Range noise: constant part (m) and part of the range.
    pub noise: f64,
    /// Part of the range noise that grows with the range.
    pub noise_fraction: f64,
    /// Nominal speed of sound, m/s.
    pub sound_speed: f64,
    /// The air's speed of sound differs from nominal by up to this fraction.
    pub sound_speed_tolerance: f64,
}

impl Default for Sonar {
    fn default() -> Self {
        let yaw = 30.0_f64.to_radians();
        Self {
            mounts: [[0.10, 0.06, yaw], [0.12, 0.0, 0.0], [0.10, -0.06, -yaw]],
            mount_height: 0.10,
            half_angle: 15.0_f64.to_radians(),
            minimum_range: 0.02,
            maximum_range: 4.0,
            dropout: 0.02,
            noise: 0.002,
            noise_fraction: 0.004,
            sound_speed: 343.0,
            sound_speed_tolerance: 0.01,
        }
    }
}

/// An LSM6DSO, along base_link's axes; standard deviations are those of its datasheet.
#[derive(Clone, Debug, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Inertial {
    /// Whether the rover has one.
    pub fitted: bool,
    /// Standard deviation of each axis's rate at rest, rad/s.
    pub rate_bias: f64,
    /// And of its change over a kelvin, rad/s/K.
    pub rate_bias_per_kelvin: f64,
    /// Of the rate's scale.
    pub rate_scale: f64,
    /// Of one reading's rate, rad/s.
    pub rate_noise: f64,
    /// Of what each axis feels too much, after the board was set level once, m/s².
    pub felt_bias: f64,
    /// Of one reading, m/s².
    pub felt_noise: f64,
    /// What a rolling rover adds to that, m/s².
    pub vibration: f64,
    /// When it is switched on, °C.
    pub celsius: f64,
    /// How much warmer it gets, K, and with which time constant, s.
    pub warming: f64,
    /// Time constant of that, s.
    pub warming_s: f64,
}

impl Default for Inertial {
    fn default() -> Self {
        Self {
            fitted: false,
            rate_bias: 0.017,
            rate_bias_per_kelvin: 1.7e-4,
            rate_scale: 0.005,
            rate_noise: 1.0e-3,
            felt_bias: 0.03,
            felt_noise: 0.01,
            vibration: 0.3,
            celsius: 22.0,
            warming: 8.0,
            warming_s: 300.0,
        }
    }
}

/// A radiometric camera on the mast. Pixel (u, v) looks along ((u - cx)/fx, (v - cy)/fy, 1) in camera_optical.
#[derive(Clone, Debug, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Camera {
    /// Pixels.
    pub width: usize,
    /// Pixels.
    pub height: usize,
    /// Focal length along a row, pixels.
    pub fx: f64,
    /// Focal length along a column, pixels.
    pub fy: f64,
    /// Principal point, pixels.
    pub cx: f64,
    /// Principal point, pixels.
    pub cy: f64,
    /// Lens on base_link, metres ahead.
    pub mount_x: f64,
    /// Lens on base_link, metres to the left.
    pub mount_y: f64,
    /// Lens above the ground, metres.
    pub mount_z: f64,
    /// Columns: the optical axes (right, down, forward) in base_link.
    pub rotation: [[f64; 3]; 3],
    /// Time of the first picture, µs.
    pub first_exposure_us: u64,
    /// Between two pictures, µs.
    pub period_us: u64,
    /// From the exposure until the companion has the picture, µs.
    pub latency_us: u64,
    /// Temporal noise of one pixel, kelvin.
    pub netd: f64,
    /// Standard deviations of the fixed pattern that each FFC leaves, kelvin.
    pub row_pattern: f64,
    /// As for the rows.
    pub column_pattern: f64,
    /// As for the rows, of each pixel alone.
    pub pixel_pattern: f64,
    /// How much colder the corners look than the centre, kelvin.
    pub vignetting: f64,
    /// Begin of the first shutter calibration, µs.
    pub ffc_first_us: u64,
    /// Between the beginnings of two, µs.
    pub ffc_period_us: u64,
    /// How long one lasts, µs.
    pub ffc_duration_us: u64,
    /// Distortion of the lens: k1, k2, p1, p2, k3.
    pub lens: Lens,
    /// What a real sensor does besides.
    pub bolometer: Bolometer,
}

impl Default for Camera {
    fn default() -> Self {
        let focal = 80.0 / 28.5_f64.to_radians().tan();
        let (sine, cosine) = 52.0_f64.to_radians().sin_cos();
        Self {
            width: 160,
            height: 120,
            fx: focal,
            fy: focal,
            cx: 79.5,
            cy: 59.5,
            mount_x: 0.0,
            mount_y: 0.0,
            mount_z: 0.75,
            rotation: [
                [0.0, -sine, cosine],
                [-1.0, 0.0, 0.0],
                [0.0, -cosine, -sine],
            ],
            first_exposure_us: 50_000,
            period_us: 120_000,
            latency_us: 60_000,
            netd: 0.05,
            row_pattern: 0.03,
            column_pattern: 0.04,
            pixel_pattern: 0.03,
            vignetting: 0.4,
            ffc_first_us: 3_000_000,
            ffc_period_us: 90_000_000,
            ffc_duration_us: 400_000,
            lens: Lens::default(),
            bolometer: Bolometer::default(),
        }
    }
}

impl Config {
    /// Reads and checks a configuration; the error names the first field that is wrong.
    pub fn parse(json: &str) -> Result<Self, String> {
        let config: Self =
            serde_json::from_str(json).map_err(|error| format!("plant configuration: {error}"))?;
        let positive = [
            ("raster_resolution", config.raster_resolution),
            ("area_width", config.area_width),
            ("area_height", config.area_height),
            ("drive.resistance", config.drive.resistance),
            ("drive.rotor_inertia", config.drive.rotor_inertia),
            ("drive.wheel_radius", config.drive.wheel_radius),
            ("drive.slip_time_constant", config.drive.slip_time_constant),
            ("drive.slip_bursts.size", config.drive.slip_bursts.size),
            ("drive.slip_bursts.length", config.drive.slip_bursts.length),
            ("unevenness.length", config.unevenness.length),
            ("battery.capacity_ah", config.battery.capacity_ah),
            ("sonar.sound_speed", config.sonar.sound_speed),
            ("camera.fx", config.camera.fx),
            ("camera.fy", config.camera.fy),
            ("camera.mount_z", config.camera.mount_z),
            ("camera.period_us", config.camera.period_us as f64),
            ("camera.width", config.camera.width as f64),
            ("camera.height", config.camera.height as f64),
            ("camera.ffc_period_us", config.camera.ffc_period_us as f64),
            ("baud", config.baud as f64),
        ];
        if let Some((name, value)) = positive
            .iter()
            .find(|(_, value)| value.is_nan() || *value <= 0.0)
        {
            return Err(format!(
                "plant configuration: {name} must be positive, not {value}"
            ));
        }
        let camera = &config.camera;
        let whole_ticks = [
            ("camera.first_exposure_us", camera.first_exposure_us),
            ("camera.period_us", camera.period_us),
            ("camera.latency_us", camera.latency_us),
        ];
        match whole_ticks.iter().find(|(_, value)| value % 1000 != 0) {
            Some((name, value)) => Err(format!(
                "plant configuration: {name} must be whole ms, not {value} µs"
            )),
            None => Ok(config),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_said_is_the_nominal_rover() {
        let config = Config::parse(r#"{"seed": 3, "drive": {"mass": 3.0}}"#).unwrap();
        assert_eq!((config.seed, config.drive.mass), (3, 3.0));
        assert_eq!(config.drive.wheel_radius, Drive::default().wheel_radius);
    }

    #[test]
    fn the_first_thing_that_is_wrong_is_named() {
        for (json, named) in [
            (r#"{"drive": {"wheels": 3}}"#, "wheels"),
            (
                r#"{"drive": {"wheel_radius": 0}}"#,
                "drive.wheel_radius must be positive, not 0",
            ),
            (
                r#"{"camera": {"period_us": 1500}}"#,
                "camera.period_us must be whole ms, not 1500",
            ),
            ("3", "plant configuration"),
        ] {
            let error = Config::parse(json).unwrap_err();
            assert!(error.contains(named), "{error}");
        }
    }
}
