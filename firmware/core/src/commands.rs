//! What each message of the companion does. Commands may come twice, late and in any order: all of them are
//! idempotent or carry a token, a counter or an index.

use rover_protocol::messages as m;
use rover_protocol::messages::{crash_event_kind, fault_code, hello_busy_wire};
use rover_protocol::Message;

use crate::clock;
use crate::controller::Core;
use crate::io::Reboot;
use crate::link::{OutgoingFrame, Wire};
use crate::motion::Refusal;
use crate::segment_inbox::Receipt;
use crate::sensor_loss::forbids_arming;
use crate::supervisor::{Event, State};

const RESTART: u32 = 0x5242_4F54;
const BOOTLOADER: u32 = 0x424F_4F54;
const VERSION: [u8; 3] = [
    decimal(env!("CARGO_PKG_VERSION_MAJOR")),
    decimal(env!("CARGO_PKG_VERSION_MINOR")),
    decimal(env!("CARGO_PKG_VERSION_PATCH")),
];

impl Core {
    /// Dispatch one message that came in at `now_us`. Unknown ones and wrong lengths move a counter.
    pub(crate) fn command(&mut self, identifier: u16, payload: &[u8], now_us: u64, wire: Wire) {
        let now_us = now_us.max(self.now_us);
        self.link.set_time(now_us);
        if self.dispatch(identifier, payload, now_us, wire).is_none() {
            self.link.count_foreign();
        }
    }

    fn dispatch(&mut self, identifier: u16, payload: &[u8], now_us: u64, wire: Wire) -> Option<()> {
        match identifier {
            m::EmergencyStop::ID => {
                let reason = m::EmergencyStop::read(payload)?.reason;
                self.raise(Event::EmergencyCommand, reason);
            }
            m::Stop::ID => self.raise(Event::StopCommand, m::Stop::read(payload)?.reason),
            m::Disarm::ID => self.raise(Event::Disarm, m::Disarm::read(payload)?.reason),
            m::Arm::ID => self.arm(&m::Arm::read(payload)?, wire),
            m::KeepAlive::ID
            | m::SegmentTravel::ID
            | m::SegmentHeading::ID
            | m::SegmentStart::ID
                if !self.is_commanded_by(wire) =>
            {
                return None;
            }
            m::KeepAlive::ID => {
                let counter = m::KeepAlive::read(payload)?.counter;
                if is_later(self.keep_alive, counter) {
                    self.keep_alive = Some(counter);
                    self.fed_us = now_us;
                }
            }
            m::ClockRequest::ID => self.link.send_first(&m::ClockReply {
                sequence: m::ClockRequest::read(payload)?.sequence,
                receive_time: clock::low(now_us),
                turnaround: 0,
            }),
            m::SegmentTravel::ID => {
                let half = m::SegmentTravel::read(payload)?;
                let put = |core: &mut Self| {
                    core.inbox
                        .put_travel(half.index, half.duration, half.jerk_travel)
                };
                self.segment_half(half.index, put, now_us);
            }
            m::SegmentHeading::ID => {
                let half = m::SegmentHeading::read(payload)?;
                let put = |core: &mut Self| {
                    core.inbox
                        .put_heading(half.index, half.jerk_heading, half.flags)
                };
                self.segment_half(half.index, put, now_us);
            }
            m::SegmentStart::ID => {
                let start = m::SegmentStart::read(payload)?;
                self.segment_start(&start, now_us);
            }
            m::Hello::ID => self.hello(&m::Hello::read(payload)?, wire),
            m::ParameterGet::ID => {
                self.parameter_get(m::ParameterGet::read(payload)?.identifier);
            }
            m::ParameterSet::ID => self.parameter_set(&m::ParameterSet::read(payload)?),
            m::ParameterCommand::ID => {
                self.parameter_command(m::ParameterCommand::read(payload)?.command);
            }
            m::TelemetryRate::ID => {
                let rate = m::TelemetryRate::read(payload)?;
                if !self.schedule.set(rate.message, rate.period, now_us) {
                    return None;
                }
            }
            m::TestMode::ID => self.test_mode(&m::TestMode::read(payload)?, now_us)?,
            m::InjectWheels::ID => {
                self.inject_wheels(&m::InjectWheels::read(payload)?, now_us)?;
            }
            m::InjectSensors::ID => {
                self.inject_sensors(&m::InjectSensors::read(payload)?, now_us)?;
            }
            m::CrashRequest::ID => {
                self.crash_request(m::CrashRequest::read(payload)?.command)?;
            }
            m::Reboot::ID => self.reboot_wanted(&m::Reboot::read(payload)?, wire),
            _ => return None,
        }
        Some(())
    }

    /// Whether what moves the rover is taken from this wire: only from the one that its session came by.
    fn is_commanded_by(&self, wire: Wire) -> bool {
        wire == self.link.active()
    }

    /// Edge-triggered: a token counts as seen even when arming is refused, and one that is not later than all that were
    /// seen is a late copy.
    fn arm(&mut self, arm: &m::Arm, wire: Wire) {
        if !matches!(arm.token.wrapping_sub(self.arm_token), 1..=0x7fff) {
            return;
        }
        self.arm_token = arm.token;
        if self.supervisor.accepts_motion() {
            return;
        }
        let owned = self.session == Some(arm.session) && self.is_commanded_by(wire);
        let limit_mv = self.settings.low_voltage_mv;
        let empty = self.battery.is_low() || i32::from(self.battery.voltage_mv()) < limit_mv;
        let resting = matches!(self.supervisor.state(), State::Disarmed | State::Latched);
        let blind = forbids_arming(self.lost_sensors()).is_some();
        let objections = u32::from(!owned)
            | u32::from(self.emergency_input) << 1
            | u32::from(empty) << 2
            | u32::from(!resting) << 3
            | u32::from(blind) << 4;
        if objections == 0 {
            self.raise(Event::Arm, 0);
        } else {
            self.faults.count(fault_code::ARM_REFUSED, objections);
        }
    }

    fn hello(&mut self, hello: &m::Hello, wire: Wire) {
        let understood = hello.schema_hash == m::SCHEMA_HASH;
        self.faults
            .set(fault_code::SCHEMA_MISMATCH, !understood, hello.schema_hash);
        // Whoever says hello while the motors are on does not take the session away, neither on this wire nor on another.
        let holder = self.session.filter(|_| self.supervisor.is_powered());
        if let Some(holder) = holder.filter(|_| !self.is_commanded_by(wire)) {
            self.answer_busy(hello, holder, wire);
            return;
        }
        let busy = holder.is_some_and(|holder| holder != hello.session);
        let accepted = understood && !busy;
        if holder.is_none() {
            self.greeter = Some(hello.session);
            self.session = accepted.then_some(hello.session);
            self.link.select(wire);
        }
        if let Some(holder) = holder.filter(|_| busy) {
            self.link.send_urgent(&busy_message(hello, holder, wire));
        }
        let [version_major, version_minor, version_patch] = VERSION;
        self.link.send_urgent(&m::HelloReply {
            schema_hash: m::SCHEMA_HASH,
            version_major,
            version_minor,
            version_patch,
            board: self.identity.board,
        });
        self.link.send_urgent(&m::HelloBuild {
            git_hash: self.identity.git_hash,
            reset_cause: self.identity.reset_cause,
            accepted: u8::from(accepted),
            session: hello.session,
        });
        let state = self.state_message();
        self.link.send_urgent(&state);
        self.status_due = true;
    }

    /// To a companion at the end of a wire that is not the driving one's.
    fn answer_busy(&mut self, hello: &m::Hello, holder: u16, wire: Wire) {
        let busy = busy_message(hello, holder, self.link.active());
        self.link.send_aside(wire, OutgoingFrame::of(&busy));
    }

    fn segment_half(&mut self, index: u16, put: impl FnOnce(&mut Self) -> Receipt, now_us: u64) {
        self.status_due = true;
        if !self.supervisor.accepts_motion() {
            self.inbox.note_refused();
            self.reject();
            return;
        }
        match put(self) {
            Receipt::Stored => self.accept_segments_at(now_us),
            Receipt::Duplicate => {}
            Receipt::TooFarAhead => {
                self.reject();
                self.faults
                    .count(fault_code::SEGMENT_REJECTED, u32::from(index));
            }
        }
    }

    fn segment_start(&mut self, start: &m::SegmentStart, now_us: u64) {
        self.status_due = true;
        if !self.supervisor.accepts_motion() {
            self.inbox.note_refused();
            self.reject();
        } else if self.inbox.is_ahead(start.index) {
            match clock::start_time(now_us, start.start_time) {
                Some(start_us) => {
                    self.inbox.put_start(start.index, start_us);
                    self.accept_segments_at(now_us);
                }
                None => self.refuse(start.index, Refusal::StartPassed),
            }
        }
    }

    /// Accept what is complete; also called every tick, for segments that waited for room.
    pub(crate) fn accept_segments(&mut self) {
        if self.inbox.is_begun() {
            self.accept_segments_at(self.now_us);
        }
    }

    fn accept_segments_at(&mut self, now_us: u64) {
        if !self.supervisor.accepts_motion() {
            return;
        }
        while let Some((segment, start_us)) = self.inbox.complete() {
            match self.motion.accept(segment, start_us, &self.settings.motion) {
                Ok(()) => {
                    self.inbox.take();
                    self.fed_us = now_us;
                    self.status_due = true;
                }
                Err(Refusal::QueueFull) => {
                    // It stays; the tick tries again when a slot is free. Told once: the window was not kept to.
                    if self.waiting.replace(segment.index) != Some(segment.index) {
                        let index = u32::from(segment.index);
                        self.faults.count(fault_code::QUEUE_FULL, index);
                    }
                    return;
                }
                Err(refusal) => {
                    self.inbox.discard();
                    self.refuse(segment.index, refusal);
                    return;
                }
            }
        }
    }

    fn refuse(&mut self, index: u16, refusal: Refusal) {
        self.reject();
        self.status_due = true;
        let detail = (refusal as u32) << 16 | u32::from(index);
        self.faults.count(fault_code::SEGMENT_REJECTED, detail);
    }

    fn reject(&mut self) {
        self.rejected = self.rejected.saturating_add(1);
    }

    /// Only at rest, and only for whoever said hello last, of whatever schema: an old firmware can be replaced.
    fn reboot_wanted(&mut self, reboot: &m::Reboot, wire: Wire) {
        let asked = self.greeter == Some(reboot.session) && self.is_commanded_by(wire);
        if self.supervisor.is_powered() || !self.is_standing() || !asked {
            return;
        }
        match reboot.magic {
            RESTART => self.reboot = Some(Reboot::Restart),
            BOOTLOADER => self.reboot = Some(Reboot::Bootloader),
            _ => return,
        }
        self.note_event(crash_event_kind::REBOOT, 0);
    }
}

fn busy_message(hello: &m::Hello, holder: u16, wire: Wire) -> m::HelloBusy {
    m::HelloBusy {
        session: hello.session,
        holder,
        wire: match wire {
            Wire::Serial => hello_busy_wire::SERIAL,
            Wire::Can => hello_busy_wire::CAN,
        },
    }
}

/// Serial-number order (RFC 1982): later by less than half of the numbers there are. The first is later than none.
fn is_later(last: Option<u8>, counter: u8) -> bool {
    last.is_none_or(|last| matches!(counter.wrapping_sub(last), 1..=0x7f))
}

/// A short decimal number at compile time.
const fn decimal(text: &str) -> u8 {
    let mut rest = text.as_bytes();
    let mut value = 0;
    while let [digit, tail @ ..] = rest {
        value = value * 10 + (*digit - b'0');
        rest = tail;
    }
    value
}
