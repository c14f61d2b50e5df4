//! Fuzzing of receive and tick on stable Rust: hostile bytes, an honest companion's frames between them, damaged frames,
//! wild measurements, and what must hold whatever comes. Deterministic: the seed decides everything.

use rover_core::storage::{Flash, FlashError, BLOCK};
use rover_core::{Core, Identity, InertialSample, Inputs, Outputs, SonarEcho};
use rover_protocol::framing::{encode, Decoder, MAX_FRAME};
use rover_protocol::messages as m;
use rover_protocol::Message;

use crate::rig::{Random, SESSION};

/// Bytes after which another core starts, with another kind of measurements.
const EPISODE: u64 = 500_000;
/// Most that may wait to be sent: two queues of 32 frames and one that is on its way.
const MOST_WAITING: usize = 65 * MAX_FRAME;
/// Identifiers of the companion's messages with their lengths, and two that are nobody's.
pub const COMMANDS: [(u16, usize); 21] = [
    (8, 1),
    (16, 1),
    (24, 4),
    (25, 1),
    (32, 1),
    (48, 1),
    (64, 8),
    (65, 6),
    (66, 6),
    (256, 6),
    (272, 2),
    (273, 6),
    (275, 1),
    (288, 4),
    (304, 3),
    (305, 8),
    (306, 7),
    (320, 1),
    (2032, 6),
    (1, 3),
    (80, 8),
];

/// What was done, so that a run shows that it reached the inside.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Summary {
    pub bytes: u64,
    pub ticks: u64,
    /// Ticks with the motors on.
    pub powered: u64,
    /// Ticks in test mode.
    pub injected: u64,
    /// Accepted into the queue.
    pub segments: u64,
    pub bytes_sent: u64,
    pub frames_sent: u64,
    /// Frames that came by the bus, and that were sent there.
    pub bus_received: u64,
    pub bus_sent: u64,
}

/// Push `bytes` bytes through the core. Panics when the core does, or breaks an invariant.
pub fn run(bytes: u64, seed: u64) -> Summary {
    let mut summary = Summary::default();
    let mut episode = 0;
    while summary.bytes < bytes {
        let length = EPISODE.min(bytes - summary.bytes);
        Episode::new(seed, episode).run(length, &mut summary);
        episode += 1;
    }
    summary
}

/// Flash that fails now and then and reads noise now and then.
struct WornFlash {
    random: Random,
    blocks: [[u8; BLOCK]; 3],
}

impl Flash for WornFlash {
    fn erase(&mut self, page: usize) -> Result<(), FlashError> {
        self.blocks[page] = [0xff; BLOCK];
        Ok(())
    }

    fn program(&mut self, page: usize, block: &[u8; BLOCK]) -> Result<(), FlashError> {
        self.blocks[page] = *block;
        match self.random.below(4) {
            0 => Err(FlashError),
            _ => Ok(()),
        }
    }

    fn read(&mut self, page: usize, block: &mut [u8; BLOCK]) -> Result<(), FlashError> {
        *block = self.blocks[page];
        if self.random.below(4) == 0 {
            block[self.random.below(12) as usize] = self.random.next() as u8;
        }
        Ok(())
    }
}

struct Episode {
    random: Random,
    core: Core,
    flash: WornFlash,
    decoder: Decoder,
    now_us: u64,
    sequence: u8,
    token: u16,
    /// Index that the firmware expects, as it said last.
    next_index: u16,
    greeted: bool,
    /// The honest companion speaks by the bus.
    by_bus: bool,
    /// The sonar that was triggered last.
    pinged: u8,
    /// The firmware said last that it is in test mode.
    injected: bool,
    /// Wild encoders, batteries and gaps in time; otherwise wheels that do as they are told.
    wild: bool,
    /// One frame in this many comes by the bus instead; 0 is none.
    bus_share: u64,
    bus_received: u64,
    bus_sent: u64,
    encoders: [i32; 2],
    wire: Vec<u8>,
}

impl Episode {
    fn new(seed: u64, episode: u64) -> Self {
        let mut random = Random(seed.wrapping_mul(1_000_003).wrapping_add(episode));
        let mut flash = WornFlash {
            random: Random(random.next()),
            blocks: [[0xff; BLOCK]; 3],
        };
        let mut core = Core::new(Identity::default());
        core.attach_storage(&mut flash);
        Self {
            core,
            flash,
            decoder: Decoder::new(),
            now_us: random.next() >> random.below(40),
            sequence: 0,
            token: 0,
            next_index: 0,
            greeted: false,
            by_bus: false,
            pinged: 0,
            injected: false,
            wild: episode % 4 == 3,
            bus_share: [0, 1, 3][(episode % 3) as usize],
            bus_received: 0,
            bus_sent: 0,
            encoders: [0; 2],
            wire: vec![],
            random,
        }
    }

    fn run(mut self, bytes: u64, summary: &mut Summary) {
        let mut left = bytes;
        let mut outputs = Outputs::default();
        while left > 0 {
            // Two and a half times what 230400 baud bring in a millisecond, at most.
            let count = self.random.below(60).min(left) as usize;
            while self.wire.len() < count {
                self.fill();
            }
            let rest = self.wire.split_off(count);
            self.core.receive(&self.wire, self.now_us);
            self.wire = rest;
            left -= count as u64;

            let inputs = self.inputs(&outputs);
            outputs = self.core.tick(&inputs);
            self.core.serve_storage(&mut self.flash);
            summary.ticks += 1;
            summary.powered += u64::from(outputs.powered);
            let (index, frames) = (self.next_index, self.decoder.frames);
            summary.bytes_sent += self.drain() as u64;
            // A stop leaves out indexes, far more than a tick can accept.
            let accepted = self.next_index.wrapping_sub(index);
            summary.segments += u64::from(if accepted < 100 { accepted } else { 0 });
            summary.injected += u64::from(self.injected);
            self.check(&inputs, &outputs);
            summary.frames_sent += u64::from(self.decoder.frames.wrapping_sub(frames));
        }
        summary.bytes += bytes;
        summary.bus_received += self.bus_received;
        summary.bus_sent += self.bus_sent;
    }

    /// What must hold in every tick.
    fn check(&self, inputs: &Inputs, outputs: &Outputs) {
        let duties = (outputs.duty_left, outputs.duty_right);
        assert!(outputs.powered || duties == (0, 0), "duty without power");
        assert!(!(outputs.powered && inputs.emergency_stop), "drives on");
        assert!(!outputs.powered || self.greeted, "armed by a stranger");
        assert!(!outputs.powered || !self.injected, "powered in test mode");
        assert!(outputs.sonar_trigger.is_none_or(|sensor| sensor < 3));
    }

    /// Everything that the firmware sends is well-formed, and there is an end to it.
    fn drain(&mut self) -> usize {
        let mut out = [0; 512];
        let mut total = 0;
        // But for those that tell a second companion that somebody else drives, and life on a bus without one.
        let mut by_line = 0;
        loop {
            let count = self.core.transmit(&mut out);
            for byte in &out[..count] {
                if let Some(frame) = self.decoder.push(*byte) {
                    by_line += u32::from(frame.identifier != m::HelloBusy::ID);
                    self.heard(frame.identifier, frame.payload());
                }
            }
            total += count;
            assert!(total <= MOST_WAITING, "what waits to be sent is bounded");
            if count == 0 {
                break;
            }
        }
        let mut by_bus = 0;
        while let Some(frame) = self.core.transmit_frame() {
            assert!(frame.identifier < 0x800 && frame.payload().len() <= 8);
            self.heard(frame.identifier, frame.payload());
            let aside = [m::HelloBusy::ID, m::State::ID].contains(&frame.identifier);
            by_bus += u64::from(!aside);
        }
        assert!(by_bus <= 64 && (by_bus == 0 || by_line == 0), "one wire");
        self.bus_sent += by_bus;
        let damage = (
            self.decoder.checksum_errors,
            self.decoder.malformed,
            self.decoder.lost,
        );
        assert_eq!(damage, (0, 0, 0));
        total
    }

    fn heard(&mut self, identifier: u16, payload: &[u8]) {
        assert!(identifier > 32, "the firmware sends no command");
        if let Some(state) = m::State::read(payload).filter(|_| identifier == 96) {
            self.injected = state.flags & 1 << 4 != 0;
            self.token = state.arm_token;
        }
        if identifier == m::MotionStatus::ID {
            let status = m::MotionStatus::read(payload).expect("has its length");
            assert!(status.free_slots <= 64 && status.queued <= 65);
            self.next_index = status.next_index;
        }
    }

    fn inputs(&mut self, last: &Outputs) -> Inputs {
        let random = &mut self.random;
        let gap = if self.wild && random.below(200) == 0 {
            random.next() >> (20 + random.below(44))
        } else {
            1_000
        };
        self.now_us = self.now_us.saturating_add(gap);
        self.pinged = last.sonar_trigger.unwrap_or(self.pinged);
        let sonar = (random.below(8) == 0).then(|| SonarEcho {
            sensor: match random.below(4) {
                0 => random.below(5) as u8,
                _ => self.pinged,
            },
            echo_us: match random.below(4) {
                0 => random.next() as u32 >> random.below(32),
                _ => 0,
            },
        });
        for (encoder, duty) in self
            .encoders
            .iter_mut()
            .zip([last.duty_left, last.duty_right])
        {
            // 3.4 counts a millisecond at full duty.
            *encoder = encoder.wrapping_add(i32::from(duty) * 34 / 327_670);
            if self.wild && random.below(50) == 0 {
                *encoder = random.next() as i32 >> random.below(32);
            }
        }
        Inputs {
            now_us: self.now_us,
            began_us: self.now_us,
            encoder_left: self.encoders[0],
            encoder_right: self.encoders[1],
            battery_mv: if self.wild {
                random.next() as u16
            } else {
                7_400
            },
            emergency_stop: random.below(5_000) == 0,
            bumper: random.below(2_000) == 0,
            sonar,
            inertial: inertial_sample(random),
        }
    }

    /// Append some bytes to the wire: noise, frames of anything, an honest companion's frames; sometimes damaged.
    fn fill(&mut self) {
        let from = self.wire.len();
        match self.random.below(8) {
            0 => self.noise(),
            1 => self.any_frame(),
            2 if self.random.below(6) == 0 => self.inject(),
            2 if self.random.below(5) == 0 => self.intrude(),
            2 => self.greet(),
            _ => self.motion(),
        }
        if self.random.below(10) == 0 && self.wire.len() > from {
            let at = from + self.random.below((self.wire.len() - from) as u64) as usize;
            match self.random.below(4) {
                0 => self.wire[at] ^= 1 << self.random.below(8),
                1 => self.wire.truncate(at),
                2 => self.wire.extend_from_within(from..),
                _ => drop(self.wire.remove(at)),
            }
        }
    }

    fn noise(&mut self) {
        let shift = self.random.below(9).min(7);
        for _ in 0..self.random.below(40) {
            self.wire.push(self.random.next() as u8 >> shift);
        }
    }

    fn any_frame(&mut self) {
        let (identifier, length) = COMMANDS[self.random.below(COMMANDS.len() as u64) as usize];
        // Rarely what ends every drive, or none would get far.
        if matches!(identifier, 8 | 16 | 25) && self.random.below(40) != 0 {
            return;
        }
        let payload = self.random.next().to_le_bytes();
        let length = length + usize::from(self.random.below(40) == 0);
        let by_bus = self.bus_share != 0 && self.random.below(self.bus_share) == 0;
        self.emit(identifier, &payload[..length.min(8)], by_bus);
    }

    fn greet(&mut self) {
        self.greeted = true;
        self.by_bus = match self.bus_share {
            0 => false,
            share => self.random.below(share) == 0,
        };
        self.put(&m::Hello {
            schema_hash: m::SCHEMA_HASH,
            session: SESSION,
        });
        self.token = self.token.wrapping_add(1);
        self.put(&m::Arm {
            token: self.token,
            session: SESSION,
        });
        self.put(&m::KeepAlive {
            counter: self.token as u8,
        });
    }

    /// Another companion on either wire, which knows the protocol and would like to drive.
    fn intrude(&mut self) {
        let by_bus = self.bus_share != 0 && self.random.below(2) == 0;
        let session = SESSION + 1 + self.random.below(3) as u16;
        let mut hello = [0; 8];
        m::Hello {
            schema_hash: m::SCHEMA_HASH,
            session,
        }
        .write(&mut hello);
        self.emit(m::Hello::ID, &hello[..m::Hello::LENGTH], by_bus);
        let mut arm = [0; 8];
        m::Arm {
            token: self.token.wrapping_add(1),
            session,
        }
        .write(&mut arm);
        self.emit(m::Arm::ID, &arm[..m::Arm::LENGTH], by_bus);
        self.greeted = true;
    }

    /// Test mode begins, goes on or ends.
    fn inject(&mut self) {
        let [left, right] = self.encoders;
        let enable = self.random.below(3).min(1) as u8;
        self.put(&m::TestMode {
            enable,
            key: 0x5445,
        });
        self.put(&m::InjectWheels { left, right });
        let sensors = m::InjectSensors {
            battery: 7_400,
            emergency_stop: u8::from(self.random.below(50) == 0),
            bumper: u8::from(self.random.below(50) == 0),
            sonar: self.random.below(4) as u8,
            echo: self.random.next() as u32 >> self.random.below(32),
        };
        self.put(&sensors);
    }

    /// A run from rest to rest, or a segment that may or may not fit.
    fn motion(&mut self) {
        let first = self.next_index;
        let start_us = self.now_us + self.random.below(40_000);
        let piece_us = 20_000 + self.random.below(100_000) as u32;
        let jerk = self.random.below(6_000_000) as i32 - 3_000_000;
        let turn = self.random.below(9_000_000) as i32 - 4_500_000;
        self.put(&m::SegmentStart {
            index: first,
            start_time: start_us as u32,
        });
        for (i, sign) in (0_u16..).zip([1, -1, -1, 1]) {
            let index = first.wrapping_add(i);
            let flags = u8::from(i == 0) | u8::from(i == 3) << 1;
            let (duration, flags) = match self.random.below(100) {
                0 => (self.random.next() as u32 >> 8, self.random.next() as u8),
                _ => (piece_us, flags),
            };
            self.put(&m::SegmentTravel {
                index,
                duration,
                jerk_travel: sign * jerk,
            });
            self.put(&m::SegmentHeading {
                index,
                jerk_heading: sign * turn,
                flags,
            });
        }
    }

    fn put<M: Message>(&mut self, message: &M) {
        let mut payload = [0; 8];
        message.write(&mut payload);
        self.emit(M::ID, &payload[..M::LENGTH], self.by_bus);
    }

    /// A frame by either wire. Those of the bus come at once, those of the line wait for their turn.
    fn emit(&mut self, identifier: u16, payload: &[u8], by_bus: bool) {
        if by_bus {
            self.core.receive_frame(identifier, payload, self.now_us);
            self.bus_received += 1;
            // As many bytes as it would have been there, of which nothing comes.
            self.wire.extend_from_slice(&[0; 8]);
            return;
        }
        let mut out = [0; MAX_FRAME];
        let count = encode(identifier, self.sequence, payload, &mut out);
        self.sequence = self.sequence.wrapping_add(1);
        self.wire.extend_from_slice(&out[..count]);
    }
}

/// Anything that sixteen bits may say, every fourth tick.
fn inertial_sample(random: &mut Random) -> Option<InertialSample> {
    let wide = random.below(16);
    (random.below(4) == 0).then(|| InertialSample {
        gyro: std::array::from_fn(|_| random.next() as i16 >> wide),
        acceleration: std::array::from_fn(|_| random.next() as i16 >> random.below(16)),
        temperature: random.next() as i16,
    })
}
