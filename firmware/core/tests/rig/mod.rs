//! A companion, a pair of motors and the core between them, in virtual time. Nothing here looks inside the core.
#![allow(dead_code, unused_imports)] // each test file uses its own part

mod motor;

pub use motor::{Motor, MotorKind, HEAVY, LIGHT};

use rover_core::{Core, Identity, InertialSample, Inputs, Outputs, SonarEcho};
use rover_protocol::framing::{encode_message, Decoder, Frame, MAX_FRAME};
use rover_protocol::messages as m;
use rover_protocol::Message;

/// Of the companion that says hello.
pub const SESSION: u16 = 1;

/// SplitMix64: the same numbers on every machine.
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    pub fn below(&mut self, bound: u64) -> u64 {
        self.next() % bound
    }
}

/// Jerk of travel and heading (um/s^3, urad/s^3) for some microseconds.
pub type Piece = (u32, i32, i32);

pub struct Rig {
    pub core: Core,
    pub motors: [Motor; 2],
    pub battery_mv: u16,
    pub emergency_stop: bool,
    pub bumper: bool,
    /// Of each fourth tick, when there is a sensor.
    pub inertial: Option<InertialSample>,
    /// Range that each sonar sees, mm; None is a timeout.
    pub ranges_mm: [Option<u32>; 3],
    pub now_us: u64,
    pub outputs: Outputs,
    /// Every frame that the firmware has sent.
    pub frames: Vec<Frame>,
    /// Feed the dead-man by KeepAlive every 50 ms.
    pub keep_alive: bool,
    pub next_index: u16,
    decoder: Decoder,
    sequence: u8,
    token: u16,
    echo: Option<(u64, SonarEcho)>,
}

impl Rig {
    pub fn new() -> Self {
        Self::with_motors(HEAVY)
    }

    pub fn with_motors(kind: MotorKind) -> Self {
        Self {
            core: Core::new(Identity::default()),
            motors: [Motor::new(kind), Motor::new(kind)],
            battery_mv: 7_400,
            emergency_stop: false,
            bumper: false,
            inertial: None,
            ranges_mm: [None; 3],
            now_us: 0,
            outputs: Outputs::default(),
            frames: vec![],
            keep_alive: true,
            next_index: 0,
            decoder: Decoder::new(),
            sequence: 0,
            token: 0,
            echo: None,
        }
    }

    /// Booted, greeted and armed.
    pub fn armed() -> Self {
        let mut rig = Self::new();
        rig.make_armed();
        rig
    }

    pub fn make_armed(&mut self) {
        self.run_ms(100);
        self.send(&m::Hello {
            schema_hash: m::SCHEMA_HASH,
            session: SESSION,
        });
        self.arm();
        self.run_ms(2);
        assert_eq!(self.state().state, m::state_state::ARMED);
    }

    /// A new token.
    pub fn arm(&mut self) {
        self.token += 1;
        self.send(&m::Arm {
            token: self.token,
            session: SESSION,
        });
    }

    pub fn send<M: Message>(&mut self, message: &M) {
        let mut wire = [0; MAX_FRAME];
        let length = encode_message(message, self.sequence, &mut wire);
        self.sequence = self.sequence.wrapping_add(1);
        self.core.receive(&wire[..length], self.now_us);
    }

    pub fn send_halves(&mut self, index: u16, piece: Piece, flags: u8) {
        let (duration, jerk_travel, jerk_heading) = piece;
        self.send(&m::SegmentTravel {
            index,
            duration,
            jerk_travel,
        });
        self.send(&m::SegmentHeading {
            index,
            jerk_heading,
            flags,
        });
    }

    pub fn send_start(&mut self, index: u16, start_us: u64) {
        self.send(&m::SegmentStart {
            index,
            start_time: start_us as u32,
        });
    }

    /// Send a whole run that starts 50 ms from now; `rests` says whether its last segment ends at rest.
    pub fn send_run(&mut self, pieces: &[Piece], rests: bool) {
        self.send_start(self.next_index, self.now_us + 50_000);
        for (i, piece) in pieces.iter().enumerate() {
            let last = i + 1 == pieces.len();
            let flags = u8::from(i == 0) | u8::from(last && rests) << 1;
            self.send_halves(self.next_index, *piece, flags);
            self.next_index = self.next_index.wrapping_add(1);
        }
    }

    pub fn tick(&mut self) -> Outputs {
        self.now_us += 1_000;
        if self.keep_alive && self.now_us.is_multiple_of(50_000) {
            let counter = (self.now_us / 50_000) as u8;
            self.send(&m::KeepAlive { counter });
        }
        let due = self.echo.filter(|(at, _)| *at <= self.now_us);
        if due.is_some() {
            self.echo = None;
        }
        let inputs = Inputs {
            now_us: self.now_us,
            began_us: self.now_us,
            encoder_left: self.motors[0].counts(),
            encoder_right: self.motors[1].counts(),
            battery_mv: self.battery_mv,
            emergency_stop: self.emergency_stop,
            bumper: self.bumper,
            sonar: due.map(|(_, echo)| echo),
            inertial: self.inertial_sample(),
        };
        self.outputs = self.core.tick(&inputs);
        if let Some(sensor) = self.outputs.sonar_trigger {
            let echo_us = self.ranges_mm[usize::from(sensor)].map_or(0, |mm| mm * 2_000 / 343);
            let delay_us = if echo_us == 0 {
                30_000
            } else {
                u64::from(echo_us)
            };
            self.echo = Some((self.now_us + delay_us, SonarEcho { sensor, echo_us }));
        }
        let duties = [self.outputs.duty_left, self.outputs.duty_right];
        for (motor, duty) in self.motors.iter_mut().zip(duties) {
            motor.step_1ms(self.outputs.powered.then_some(duty), self.battery_mv);
        }
        let mut bytes = [0; 64];
        loop {
            let count = self.core.transmit(&mut bytes);
            if count == 0 {
                return self.outputs;
            }
            let decoder = &mut self.decoder;
            self.frames
                .extend(bytes[..count].iter().filter_map(|byte| decoder.push(*byte)));
        }
    }

    /// Every fourth tick, and never twice the same: noise changes the last bit.
    fn inertial_sample(&self) -> Option<InertialSample> {
        let sample = self.inertial?;
        let noise = (self.now_us / 4_000 % 2) as i16;
        self.now_us.is_multiple_of(4_000).then_some(InertialSample {
            temperature: sample.temperature + noise,
            ..sample
        })
    }

    pub fn run_ms(&mut self, milliseconds: u64) {
        for _ in 0..milliseconds {
            self.tick();
        }
    }

    /// Tick until the state is `state`; panics after ten seconds. Returns the milliseconds.
    pub fn run_until_state(&mut self, state: u8) -> u64 {
        for ms in 0..10_000 {
            if self.state().state == state {
                return ms;
            }
            self.tick();
        }
        panic!("state {state} did not come, it is {:?}", self.state());
    }

    /// The last message of a kind.
    pub fn last<M: Message>(&self) -> Option<M> {
        self.frames
            .iter()
            .rev()
            .find(|frame| frame.identifier == M::ID)
            .and_then(|frame| M::read(frame.payload()))
    }

    pub fn all<M: Message>(&self) -> Vec<M> {
        self.frames
            .iter()
            .filter(|frame| frame.identifier == M::ID)
            .filter_map(|frame| M::read(frame.payload()))
            .collect()
    }

    pub fn state(&self) -> m::State {
        self.last().unwrap_or_default()
    }

    pub fn status(&self) -> m::MotionStatus {
        self.last().unwrap_or_default()
    }

    /// Travel of both wheels' middle and heading, as the motors really turned (m, rad).
    pub fn driven(&self) -> (f64, f64) {
        let [left, right] = &self.motors;
        (
            (left.position + right.position) / 2.0,
            (right.position - left.position) / 0.2,
        )
    }
}

/// Straight or turning: jerk up, hold, jerk down, cruise, and back; 0.25 m/s when `travel` is 3e6 um/s^3.
pub fn cruise_pieces(travel: i32, heading: i32, cruise_us: u32) -> Vec<Piece> {
    // 3 m/s^3 for 1/6 s is 0.5 m/s^2; held 1/3 s more gives 0.25 m/s.
    let (ramp, hold) = (166_667, 333_333);
    vec![
        (ramp, travel, heading),
        (hold, 0, 0),
        (ramp, -travel, -heading),
        (cruise_us, 0, 0),
        (ramp, -travel, -heading),
        (hold, 0, 0),
        (ramp, travel, heading),
    ]
}
