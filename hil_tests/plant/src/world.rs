//! Everything that is simulated, stepped 1 ms at a time; with the firmware in the loop, tick by tick.

use std::io::{Error, ErrorKind, Result};

use crate::attitude::{Stance, Unevenness};
use crate::battery::Battery;
use crate::bumper;
use crate::camera::{Camera, Frame};
use crate::config::Config;
use crate::drive::{Bridge, Drive};
use crate::faults::{Faults, InertialFault};
use crate::hand::Hand;
use crate::inertial::Inertial;
use crate::obstacle::{block, Obstacle};
use crate::pose::Pose;
use crate::random::Random;
use crate::referee::Referee;
use crate::sitl::{Sensors, Sitl};
use crate::sonar::{Echo, Sonar};
use crate::survey::Survey;
use crate::terrain::Terrain;
use crate::wire::Wire;

/// One tick of the firmware, microseconds.
pub const TICK_US: u64 = 1000;
/// The referee looks every so often, microseconds.
const LOOK_US: u64 = 10_000;
/// The ground's temperature is brought up to date every so often, microseconds.
const WARM_US: u64 = 1_000_000;

/// Where the world stood when its firmware was switched on.
#[derive(Default)]
struct Begin {
    now_us: u64,
    host_bytes: u64,
    bytes_sent: u64,
}

/// The rover, its field and its firmware.
pub struct World {
    /// Time since the start of the world, µs.
    pub now_us: u64,
    /// True pose of base_link.
    pub pose: Pose,
    /// The pack.
    pub battery: Battery,
    /// Wheels and motors.
    pub drive: Drive,
    /// The ultrasonic sensors.
    pub sonar: Sonar,
    /// The thermal camera.
    pub camera: Camera,
    /// The inertial sensor, whether the rover has one or not.
    pub inertial: Inertial,
    /// The ground.
    pub terrain: Terrain,
    /// What makes the rover lean on it.
    pub unevenness: Unevenness,
    /// Things that the rover must not touch.
    pub obstacles: Vec<Obstacle>,
    /// What really happened so far.
    pub referee: Referee,
    /// Which ground the camera has shown.
    pub survey: Survey,
    /// What the firmware does with the motors now.
    pub bridge: Bridge,
    /// Whether the emergency stop is pressed.
    pub emergency_stop: bool,
    /// What is broken now.
    pub faults: Faults,
    /// Whether the rover's lamp is lit.
    pub led: bool,
    /// Whether the rover's buzzer sounds.
    pub buzzer: bool,
    /// Pictures exposed, not yet delivered; and delivered, not yet taken by the companion.
    exposed: Vec<Frame>,
    /// Pictures that the companion has not taken yet.
    pub delivered: Vec<Frame>,
    config: Config,
    wire: Wire,
    adc: Random,
    sitl: Option<Sitl>,
    /// Of the last tick's trigger, for the next one's request.
    ping: Option<Echo>,
    begin: Begin,
    bytes_sent: u64,
    blocked: bool,
    hand: Hand,
    /// Greatest speed against what the plant has held the rover back from since the last look, m/s; None: nothing has.
    struck: Option<f64>,
}

impl World {
    /// A rover that stands at its launch.
    pub fn new(config: Config, terrain: Terrain, obstacles: Vec<Obstacle>) -> Self {
        let mut world = Self {
            now_us: 0,
            pose: Pose {
                x: config.launch.x,
                y: config.launch.y,
                heading: config.launch.heading,
            },
            battery: Battery::new(&config.battery),
            drive: Drive::new(&config.drive, config.seed),
            sonar: Sonar::new(&config.sonar, config.seed),
            camera: Camera::new(&config.camera, config.seed),
            inertial: Inertial::new(&config.inertial, config.seed),
            terrain,
            unevenness: Unevenness::new(&config.unevenness, config.seed),
            obstacles,
            referee: Referee::new(&config),
            survey: Survey::new(&config),
            bridge: Bridge::default(),
            emergency_stop: false,
            faults: Faults::default(),
            led: false,
            buzzer: false,
            exposed: Vec::new(),
            delivered: Vec::new(),
            wire: Wire::new(config.baud),
            adc: Random::stream(config.seed, "battery"),
            sitl: None,
            ping: None,
            begin: Begin::default(),
            bytes_sent: 0,
            blocked: false,
            hand: Hand::new(config.seed),
            struck: None,
            config,
        };
        for (wheel, dead) in world
            .faults
            .wheels
            .iter_mut()
            .zip(world.config.wiring.motors_dead)
        {
            wheel.open = dead;
        }
        world.look();
        world
    }

    /// Begins where a former world has ended, with the ground that was seen in it; false when that does not fit.
    pub fn drive_on(&mut self, seen: &[bool], pose: Pose) -> bool {
        if !self.survey.add_seen(seen) {
            return false;
        }
        self.pose = pose;
        self.referee = Referee::new(&self.config);
        self.look();
        true
    }

    /// Puts a firmware into the loop that has just been switched on: its clock and its counts of bytes begin now.
    /// `host_bytes`: what the host has written so far; bytes on the wire are lost to it.
    pub fn attach(&mut self, sitl: Sitl, host_bytes: u64) {
        self.sitl = Some(sitl);
        self.bridge = Bridge::default();
        self.wire.drop_until(host_bytes);
        self.begin = Begin {
            now_us: self.now_us,
            host_bytes,
            bytes_sent: self.bytes_sent,
        };
    }

    /// Begins to keep what goes to the firmware and what it answers.
    pub fn record_ticks(&mut self) {
        if let Some(sitl) = &mut self.sitl {
            sitl.log = Some(Vec::new());
        }
    }

    /// What has been kept since the last call: for each tick the request and the reply.
    pub fn take_ticks(&mut self) -> Vec<u8> {
        let log = self.sitl.as_mut().and_then(|sitl| sitl.log.as_mut());
        log.map(std::mem::take).unwrap_or_default()
    }

    /// Lets go of the firmware: its stdin ends once the caller has closed its own end.
    pub fn detach(&mut self) {
        self.sitl = None;
    }

    /// One millisecond of physics with the bridge as it is.
    pub fn step(&mut self) {
        let dt = TICK_US as f64 * 1e-6;
        self.now_us += TICK_US;
        let travel = self.drive.step(
            self.bridge,
            self.battery.voltage(),
            self.blocked,
            &self.faults,
            dt,
        );
        self.battery
            .step(self.drive.supply_current(), self.faults.voltage_drop, dt);
        let before = self.pose;
        let rolled = self
            .pose
            .roll(travel[0], travel[1], self.config.drive.track_width);
        let (width, height) = (self.config.area_width, self.config.area_height);
        (self.pose, self.blocked) = block(
            rolled,
            self.config.footprint_radius,
            &self.obstacles,
            width,
            height,
        );
        if self.blocked {
            let speed = bumper::closing_speed(before, rolled, self.pose, dt);
            self.struck = Some(self.struck.unwrap_or(0.0).max(speed));
        }
        if self.now_us.is_multiple_of(LOOK_US) {
            self.look();
        }
        if self.now_us.is_multiple_of(WARM_US) {
            self.terrain.warm((self.now_us / WARM_US) as usize);
        }
        self.hand.step(self.faults.lifted, dt);
        if self.config.inertial.fitted && self.faults.inertial != Some(InertialFault::Frozen) {
            let (stance, lift) = (self.stance(), self.hand.lift());
            self.inertial.step(self.now_us, stance, lift, dt);
        }
        self.camera.motion = motion(before, self.pose, dt);
        self.exposed.extend(self.camera.poll(
            self.now_us,
            self.stance(),
            &self.terrain,
            self.faults.camera,
        ));
        while self
            .exposed
            .first()
            .is_some_and(|frame| frame.delivered_us <= self.now_us)
        {
            let frame = self.exposed.remove(0);
            if !frame.ffc && !frame.depth.is_empty() {
                let eye = self.camera.eye(frame.stance);
                self.survey
                    .mark(eye, frame.stance, &frame.depth, &self.terrain);
            }
            self.delivered.push(frame);
        }
    }

    /// Where the rover is and how it leans: on the ground, or as somebody holds it.
    pub fn stance(&self) -> Stance {
        let mut stance = Stance {
            pose: self.pose,
            attitude: self.unevenness.attitude(self.pose),
        };
        let tremor = self.hand.tremor();
        stance.attitude.roll += self.faults.tilt[0] + tremor[0];
        stance.attitude.pitch += self.faults.tilt[1] + tremor[1];
        stance
    }

    fn look(&mut self) {
        self.referee.look(
            self.now_us,
            self.pose,
            self.struck,
            &self.obstacles,
            &mut self.survey,
        );
        self.struck = None;
    }

    /// The echo that is back by now, if any.
    pub fn poll_echo(&mut self) -> Option<Echo> {
        self.sonar.poll(self.now_us)
    }

    /// Starts a ranging of sensor 0 to 2.
    pub fn trigger_sonar(&mut self, sensor: u8) {
        self.sonar.trigger(
            sensor,
            self.now_us,
            self.pose,
            &self.obstacles,
            &self.faults.sonars,
        );
    }

    /// Whether a switch of the bumper is pressed.
    pub fn bumper(&self) -> bool {
        let (width, height) = (self.config.area_width, self.config.area_height);
        let radius = self.config.footprint_radius;
        self.faults.bumper_pressed
            || bumper::pressed(self.pose, radius, &self.obstacles, width, height)
    }

    /// As in the tick's request: 0 no inertial sensor answers, 1 it does, 2 it holds the bus.
    pub fn inertial_state(&self) -> u8 {
        match self.faults.inertial {
            _ if !self.config.inertial.fitted => 0,
            Some(InertialFault::Silent) => 0,
            Some(InertialFault::HoldsBus) => 2,
            Some(InertialFault::Frozen) | None => 1,
        }
    }

    /// The battery as the firmware's ADC reads it, millivolts.
    pub fn measure_battery(&mut self) -> u16 {
        let noise = self.config.battery.measurement_noise * f64::from(self.adc.quick_normal());
        let read = self.battery.voltage() * self.config.wiring.battery_scale;
        ((read + noise) * 1000.0).round().clamp(0.0, 65_535.0) as u16
    }

    /// Runs physics and firmware up to `until_us`. `host_bytes` were written by the host at the present time.
    /// Returns (time µs, total) whenever the firmware's count of sent bytes has changed.
    pub fn run_until(&mut self, until_us: u64, host_bytes: u64) -> Result<Vec<(u64, u64)>> {
        let mut sitl = self.sitl.take().ok_or_else(|| {
            Error::new(
                ErrorKind::NotConnected,
                "no rover-sitl attached: call attach_sitl first",
            )
        })?;
        self.wire.write(host_bytes);
        let mut marks = Vec::new();
        let result = self.run(&mut sitl, until_us, &mut marks);
        self.sitl = Some(sitl);
        result.map(|()| marks)
    }

    fn run(&mut self, sitl: &mut Sitl, until_us: u64, marks: &mut Vec<(u64, u64)>) -> Result<()> {
        while self.now_us + TICK_US <= until_us {
            self.step();
            let sensors = Sensors {
                now_us: self.now_us - self.begin.now_us,
                counts: self.config.wiring.counts(self.drive.counts()),
                echo: self.poll_echo().map(|echo| self.config.wiring.heard(echo)),
                ping: self.ping.take(),
                battery_mv: self.measure_battery(),
                emergency_stop: self.emergency_stop,
                bumper: self.bumper(),
                inertial: self.inertial_state(),
                registers: self.inertial.registers,
                host_bytes_due: self.wire.pass(TICK_US) - self.begin.host_bytes,
            };
            let actuators = sitl.exchange(&sensors)?;
            self.bridge = self.config.wiring.bridge(actuators.bridge);
            (self.led, self.buzzer) = (actuators.led, actuators.buzzer);
            let pins = actuators.sonar_trigger;
            if let Some(sensor) = pins.and_then(|pins| self.config.wiring.sensor(pins)) {
                self.trigger_sonar(sensor);
                let ping = self.sonar.expected(sensor);
                self.ping = ping.map(|echo| self.config.wiring.heard(echo));
            }
            let bytes_sent = self.begin.bytes_sent + actuators.bytes_sent;
            if bytes_sent != self.bytes_sent {
                self.bytes_sent = bytes_sent;
                marks.push((self.now_us, self.bytes_sent));
            }
        }
        Ok(())
    }
}

/// Speed ahead and turn rate from one pose to the next.
fn motion(before: Pose, now: Pose, dt: f64) -> [f64; 2] {
    let (sine, cosine) = now.heading.sin_cos();
    let ahead = cosine * (now.x - before.x) + sine * (now.y - before.y);
    [ahead / dt, (now.heading - before.heading) / dt]
}
