//! Every command twice, late and in any order: nothing but a new Arm switches the motors on, and nothing that comes again
//! moves the rover or keeps it going.

mod rig;

use std::collections::BTreeSet;

use rig::{Random, Rig};
use rover_core::Core;
use rover_protocol::messages as m;
use rover_protocol::messages::state_state as state;
use rover_protocol::Message;

/// What comes again is as late as this at most: the counter of KeepAlive wraps after 25.6 s.
const LATEST_MS: u64 = 10_000;
/// Indexes that a flush leaves out.
const SKIPPED: u16 = 256;
const DURATION_MS: u64 = 20_000;

#[derive(Clone)]
struct Sent {
    at_ms: u64,
    identifier: u16,
    payload: Vec<u8>,
}

/// A companion that sends every kind of command, and a line that brings each after some time and some of them again.
struct Conversation {
    rig: Rig,
    random: Random,
    /// On their way: when each arrives, and whether it has never arrived before.
    on_the_way: Vec<(u64, Sent, bool)>,
    arrived: Vec<Sent>,
    session: u16,
    token: u16,
    counter: u8,
    latest_arm: u16,
    /// Indexes of the segments that came for the first time since the motors went on.
    meant: BTreeSet<u16>,
}

impl Conversation {
    fn new(seed: u64) -> Self {
        let mut rig = Rig::new();
        rig.keep_alive = false;
        Self {
            rig,
            random: Random(seed),
            on_the_way: vec![],
            arrived: vec![],
            session: 1,
            token: 0,
            counter: 0,
            latest_arm: 0,
            meant: BTreeSet::new(),
        }
    }

    fn now_ms(&self) -> u64 {
        self.rig.now_us / 1000
    }

    fn send<M: Message>(&mut self, message: &M) {
        let mut payload = [0; 8];
        message.write(&mut payload);
        let sent = Sent {
            at_ms: self.now_ms(),
            identifier: M::ID,
            payload: payload[..M::LENGTH].to_vec(),
        };
        let delay = self.random.below(40);
        self.on_the_way.push((sent.at_ms + delay, sent, true));
    }

    /// One of all commands, each now and then; keep-alive and motion often, as a driving companion does.
    fn talk(&mut self) {
        if self.now_ms().is_multiple_of(100) {
            self.counter = self.counter.wrapping_add(1);
            let counter = self.counter;
            self.send(&m::KeepAlive { counter });
        }
        let session = self.session;
        match self.random.below(4_000) {
            0 => self.send(&m::EmergencyStop { reason: 1 }),
            1 => self.send(&m::Stop { reason: 1 }),
            2 => self.send(&m::Disarm { reason: 1 }),
            3..=40 => {
                self.token = self.rig.state().arm_token.max(self.token) + 1;
                let token = self.token;
                self.send(&m::Arm { token, session });
            }
            41..=60 => self.send(&m::Hello {
                schema_hash: m::SCHEMA_HASH,
                session,
            }),
            61 => {
                self.session += 1;
                let session = self.session;
                self.send(&m::Hello {
                    schema_hash: m::SCHEMA_HASH,
                    session,
                });
            }
            62..=65 => self.send(&m::ClockRequest { sequence: 1 }),
            66..=90 => self.run(),
            91 => self.send(&m::ParameterGet { identifier: 1 }),
            92 => self.send(&m::ParameterSet {
                identifier: 50,
                value: 70,
            }),
            93 => self.send(&m::ParameterCommand { command: 0 }),
            94 => self.send(&m::TelemetryRate {
                message: 112,
                period: 20,
            }),
            95 => {
                let enable = self.random.below(2) as u8;
                self.send(&m::TestMode {
                    enable,
                    key: 0x5445,
                });
            }
            96 => self.send(&m::InjectWheels { left: 0, right: 0 }),
            97 => self.send(&m::InjectSensors {
                battery: 7_400,
                emergency_stop: 0,
                sonar: 255,
                echo: 0,
                bumper: 0,
            }),
            99 => self.send(&m::CrashRequest { command: 1 }),
            98 => self.send(&m::Reboot {
                magic: 0x5242_4F54,
                session,
            }),
            _ => {}
        }
    }

    fn run(&mut self) {
        let first = self.rig.status().next_index;
        let start_time = (self.rig.now_us + 100_000) as u32;
        self.send(&m::SegmentStart {
            index: first,
            start_time,
        });
        for (i, jerk_travel) in (0..4).zip([2_000_000, -2_000_000, -2_000_000, 2_000_000]) {
            let index = first.wrapping_add(i);
            self.send(&m::SegmentTravel {
                index,
                duration: 200_000,
                jerk_travel,
            });
            self.send(&m::SegmentHeading {
                index,
                jerk_heading: 0,
                flags: u8::from(i == 0) | u8::from(i == 3) << 1,
            });
        }
    }

    /// Also in test mode, where the bridges stay off.
    fn is_armed(&self) -> bool {
        self.rig.state().flags & 1 << 3 != 0
    }

    /// Some of what has arrived comes again.
    fn repeat(&mut self) {
        let (now, random) = (self.now_ms(), &mut self.random);
        let young = |sent: &&Sent| now - sent.at_ms < LATEST_MS;
        let candidates: Vec<&Sent> = self.arrived.iter().filter(young).collect();
        if !candidates.is_empty() && random.below(3) == 0 {
            let again = candidates[random.below(candidates.len() as u64) as usize].clone();
            self.on_the_way.push((now + random.below(50), again, false));
        }
    }

    /// A millisecond. True when anything arrived for the first time.
    fn tick(&mut self) -> bool {
        let now = self.now_ms();
        let (due, later) = self
            .on_the_way
            .drain(..)
            .partition(|(at_ms, ..)| *at_ms <= now);
        self.on_the_way = later;
        let due: Vec<(u64, Sent, bool)> = due;
        let before = (self.is_armed(), self.rig.status().next_index);
        let (mut fresh_arm, mut fresh) = (false, false);
        if !before.0 {
            self.meant.clear();
        }
        for (_, sent, first) in due {
            deliver(&mut self.rig.core, &sent, self.rig.now_us);
            if self.rig.core.take_reboot().is_some() {
                assert!(!before.0, "restarted while powered");
            }
            if !first {
                continue;
            }
            fresh = true;
            if (64..=66).contains(&sent.identifier) {
                let index = [sent.payload[0], sent.payload[1]];
                self.meant.insert(u16::from_le_bytes(index));
            }
            if let Some(arm) = m::Arm::read(&sent.payload).filter(|_| sent.identifier == m::Arm::ID)
            {
                fresh_arm |= arm.token > self.latest_arm;
                self.latest_arm = self.latest_arm.max(arm.token);
            }
            self.arrived.push(sent);
        }
        self.rig.tick();
        assert!(before.0 || !self.is_armed() || fresh_arm, "armed by a copy");
        // A flush leaves out indexes, more than a run has.
        let next = self.rig.status().next_index;
        if next.wrapping_sub(before.1) < SKIPPED {
            for index in before.1..next {
                let known = self.meant.contains(&index);
                assert!(known, "segment {index} was sent to an earlier arming");
            }
        }
        fresh
    }
}

fn deliver(core: &mut Core, sent: &Sent, now_us: u64) {
    let mut wire = [0; rover_protocol::framing::MAX_FRAME];
    let length = rover_protocol::framing::encode(sent.identifier, 0, &sent.payload, &mut wire);
    core.receive(&wire[..length], now_us);
}

#[test]
fn what_comes_again_or_late_arms_nothing_moves_nothing_and_feeds_nothing() {
    let (mut powered_ms, mut driven_ms, mut kinds) = (0, 0, BTreeSet::new());
    for seed in 0..40 {
        let mut conversation = Conversation::new(seed);
        for _ in 0..DURATION_MS {
            conversation.talk();
            conversation.repeat();
            conversation.tick();
            powered_ms += u64::from(conversation.rig.outputs.powered);
            driven_ms += u64::from(conversation.rig.state().state == state::MOVING);
        }
        // The companion is gone and the line goes on to repeat: the dead-man is not fed by that.
        conversation.on_the_way.retain(|(.., first)| !first);
        let gone_ms = conversation.now_ms();
        for _ in 0..2_000 {
            conversation.repeat();
            assert!(!conversation.tick());
            let waited = conversation.now_ms() - gone_ms;
            let powered = conversation.rig.outputs.powered;
            assert!(!powered || waited < 1_200, "fed by copies, seed {seed}");
        }
        kinds.extend(conversation.arrived.iter().map(|sent| sent.identifier));
    }
    assert!(
        powered_ms > 40_000 && driven_ms > 5_000,
        "{powered_ms} {driven_ms}"
    );
    assert_eq!(kinds.len(), 19, "every kind of command: {kinds:?}");
}
