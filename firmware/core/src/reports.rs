//! What the firmware says of itself: the content of every telemetry message.

use rover_protocol::messages as m;
use rover_protocol::messages::{fault_code, sonar_status};
use rover_protocol::Message;

use crate::clock;
use crate::controller::Core;
use crate::link::{OutgoingFrame, BEAT_US};
use crate::sonar::{Ranging, SonarStatus};
use crate::supervisor::State;
use crate::telemetry::MESSAGES;

impl Core {
    /// Acknowledgement, faults, scheduled telemetry and log lines of this tick.
    pub(crate) fn send_reports(&mut self) {
        if core::mem::take(&mut self.status_due) {
            let status = self.motion_status();
            self.link.send_urgent(&status);
        }
        if self.schedule.is_due(self.now_us) {
            self.send_telemetry();
        }
        if self.now_us >= self.beat_us {
            self.beat_us = self.now_us.saturating_add(BEAT_US);
            let state = self.state_message();
            self.link.beat(&state);
        }
        self.tell_crash();
        let dropped = self.link.take_dropped();
        if dropped > 0 {
            self.faults
                .count(fault_code::TRANSMIT_OVERFLOW, u32::from(dropped));
        }
        if self.link.has_urgent_room() {
            if let Some(fault) = self.faults.report(self.now_us) {
                self.link.send_urgent(&fault);
            }
        }
        if self.link.has_time() {
            if let Some(piece) = self.log.piece() {
                self.link.send_routine(OutgoingFrame::of(&piece));
            }
        }
    }

    fn send_telemetry(&mut self) {
        self.odometry.integrate(&self.settings.geometry);
        for place in 0..MESSAGES {
            let due = self.schedule.take_due(place, self.now_us);
            if let Some(frame) = due.and_then(|identifier| self.telemetry(identifier)) {
                self.link.send_routine(frame);
            }
        }
        self.schedule.look_ahead();
    }

    /// Sonar is sent when a ping has ended, not by the clock.
    pub(crate) fn report_ranging(&mut self, ranging: &Ranging) {
        if !self.schedule.sonar_wanted() {
            return;
        }
        let status = match ranging.status {
            SonarStatus::Ok => sonar_status::OK,
            SonarStatus::NoEcho => sonar_status::NO_ECHO,
            SonarStatus::Dead => sonar_status::DEAD,
        };
        let message = m::Sonar {
            sensor: ranging.sensor,
            status,
            range: ranging.range_mm,
            time: clock::low(ranging.ping_us),
        };
        self.link.send_routine(OutgoingFrame::of(&message));
    }

    fn telemetry(&mut self, identifier: u16) -> Option<OutgoingFrame> {
        Some(match identifier {
            m::State::ID => OutgoingFrame::of(&self.state_message()),
            m::MotionStatus::ID => OutgoingFrame::of(&self.motion_status()),
            m::WheelTicks::ID => OutgoingFrame::of(&self.wheel_ticks()),
            m::OdometryPosition::ID => {
                let [x, y] = self.odometry.position_10um();
                OutgoingFrame::of(&m::OdometryPosition { x, y })
            }
            m::OdometryHeading::ID => OutgoingFrame::of(&m::OdometryHeading {
                heading: self.odometry.heading_urad(),
                time: clock::low(self.now_us),
            }),
            m::Velocity::ID => OutgoingFrame::of(&self.velocity()),
            m::ReferenceDistance::ID => OutgoingFrame::of(&self.reference_distance()),
            m::Battery::ID => OutgoingFrame::of(&m::Battery {
                voltage: self.battery.voltage_mv(),
                minimum: self.battery.minimum_mv(),
            }),
            m::MotorDuty::ID => {
                let [left, right] = &self.wheels;
                OutgoingFrame::of(&m::MotorDuty {
                    left: left.duty(),
                    right: right.duty(),
                })
            }
            m::InertialHeading::ID if self.inertial.is_good() => {
                OutgoingFrame::of(&m::InertialHeading {
                    heading: self.inertial.heading_urad(self.now_us),
                    rate: self.inertial.rate_mrad_s(),
                    time: (self.now_us / 1000) as u16,
                })
            }
            m::Gravity::ID => {
                let status = self.inertial.status()?;
                let [x, y, z] = self.inertial.up_mm_s2();
                let shake = self.inertial.take_shake();
                OutgoingFrame::of(&m::Gravity {
                    x,
                    y,
                    z,
                    shake,
                    status,
                })
            }
            m::LinkStatistics::ID => OutgoingFrame::of(&self.link.statistics()),
            _ => return None,
        })
    }

    pub(crate) fn state_message(&self) -> m::State {
        let (cause, cause_detail) = self.supervisor.cause();
        let moving = self.supervisor.state() == State::Moving || self.supervisor.is_stopping();
        let flags = [
            self.session.is_some(),
            self.emergency_input,
            moving,
            self.supervisor.is_powered(),
            self.injection.is_some(),
            self.bumper.is_pressed(),
        ];
        m::State {
            state: self.supervisor.state_number(),
            cause,
            cause_detail,
            faults: self.faults.active(),
            arm_token: self.arm_token,
            flags: (0..)
                .zip(flags)
                .fold(0, |bits, (at, flag)| bits | u8::from(flag) << at),
        }
    }

    pub(crate) fn motion_status(&self) -> m::MotionStatus {
        m::MotionStatus {
            next_index: self.inbox.next_index(),
            free_slots: self.motion.free_slots() as u8,
            queued: self.motion.queued() as u8,
            executing: self.motion.executing(),
            rejected: self.rejected,
        }
    }

    fn wheel_ticks(&self) -> m::WheelTicks {
        let [left, right] = self.odometry.counts();
        m::WheelTicks {
            time: (self.now_us / 1000) as u16,
            left: left as i32,
            right: right as i32,
        }
    }

    fn velocity(&self) -> m::Velocity {
        let reference = self.motion.reference();
        let [left, right] = self
            .wheels
            .each_ref()
            .map(|wheel| i64::from(wheel.velocity_um_s()));
        let track_um = self
            .parameters
            .value(crate::parameters::Parameter::TrackUm)
            .max(1);
        // um/s over um is 1/s; mrad/s are wanted.
        let turn = (right - left) * 1000;
        m::Velocity {
            reference_travel: short(reference.travel.velocity_micro() / 100),
            reference_heading: short(reference.heading.velocity_micro() / 1000),
            measured_travel: short((left + right) / 200),
            measured_heading: short(turn.checked_div(track_um).unwrap_or(0)),
        }
    }

    fn reference_distance(&self) -> m::ReferenceDistance {
        let reference = self.motion.reference();
        m::ReferenceDistance {
            travel: long(reference.travel.position_nano() / 10_000),
            // Wraps, as the odometry's.
            heading: (reference.heading.position_nano() / 1000) as i32,
        }
    }
}

fn short(value: i64) -> i16 {
    value.clamp(i64::from(i16::MIN), i64::from(i16::MAX)) as i16
}

fn long(value: i64) -> i32 {
    value.clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32
}
