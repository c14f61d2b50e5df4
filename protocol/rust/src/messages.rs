//! Messages of `protocol/rover.dbc`, raw integers as on the wire.
//!
//! Written by `python -m tools.generate`: change the DBC, not this file. A 24-bit field is held in 32 bits;
//! its upper byte is dropped by `write` and restored by sign extension in `read`.

use crate::Message;

/// CRC-32 of the normalised DBC; `Hello` carries it, a mismatch is refused.
pub const SCHEMA_HASH: u32 = 0x48fda56d;

/// Length of a message's payload, `None` for an identifier that is not in the DBC.
pub const fn length(identifier: u16) -> Option<usize> {
    match identifier {
        EmergencyStop::ID => Some(EmergencyStop::LENGTH),
        Stop::ID => Some(Stop::LENGTH),
        Arm::ID => Some(Arm::LENGTH),
        Disarm::ID => Some(Disarm::LENGTH),
        KeepAlive::ID => Some(KeepAlive::LENGTH),
        ClockRequest::ID => Some(ClockRequest::LENGTH),
        ClockReply::ID => Some(ClockReply::LENGTH),
        SegmentTravel::ID => Some(SegmentTravel::LENGTH),
        SegmentHeading::ID => Some(SegmentHeading::LENGTH),
        SegmentStart::ID => Some(SegmentStart::LENGTH),
        MotionStatus::ID => Some(MotionStatus::LENGTH),
        State::ID => Some(State::LENGTH),
        WheelTicks::ID => Some(WheelTicks::LENGTH),
        OdometryPosition::ID => Some(OdometryPosition::LENGTH),
        OdometryHeading::ID => Some(OdometryHeading::LENGTH),
        Velocity::ID => Some(Velocity::LENGTH),
        ReferenceDistance::ID => Some(ReferenceDistance::LENGTH),
        InertialHeading::ID => Some(InertialHeading::LENGTH),
        Gravity::ID => Some(Gravity::LENGTH),
        Sonar::ID => Some(Sonar::LENGTH),
        Battery::ID => Some(Battery::LENGTH),
        MotorDuty::ID => Some(MotorDuty::LENGTH),
        Fault::ID => Some(Fault::LENGTH),
        LinkStatistics::ID => Some(LinkStatistics::LENGTH),
        LogText::ID => Some(LogText::LENGTH),
        Hello::ID => Some(Hello::LENGTH),
        HelloReply::ID => Some(HelloReply::LENGTH),
        HelloBuild::ID => Some(HelloBuild::LENGTH),
        HelloBusy::ID => Some(HelloBusy::LENGTH),
        ParameterGet::ID => Some(ParameterGet::LENGTH),
        ParameterSet::ID => Some(ParameterSet::LENGTH),
        ParameterValue::ID => Some(ParameterValue::LENGTH),
        ParameterCommand::ID => Some(ParameterCommand::LENGTH),
        TelemetryRate::ID => Some(TelemetryRate::LENGTH),
        TestMode::ID => Some(TestMode::LENGTH),
        InjectWheels::ID => Some(InjectWheels::LENGTH),
        InjectSensors::ID => Some(InjectSensors::LENGTH),
        CrashRequest::ID => Some(CrashRequest::LENGTH),
        CrashCause::ID => Some(CrashCause::LENGTH),
        CrashTime::ID => Some(CrashTime::LENGTH),
        CrashEvent::ID => Some(CrashEvent::LENGTH),
        Reboot::ID => Some(Reboot::LENGTH),
        _ => None,
    }
}

/// Cut the motors at once and latch. Needs no state, is never refused.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EmergencyStop {
    /// Free for the sender; echoed in State.cause_detail.
    pub reason: u8,
}

impl Message for EmergencyStop {
    const ID: u16 = 0x008;
    const LENGTH: usize = 1;

    fn write(&self, out: &mut [u8; 8]) {
        let b0 = self.reason;
        *out = [b0, 0, 0, 0, 0, 0, 0, 0];
    }

    fn read(payload: &[u8]) -> Option<Self> {
        let p: &[u8; 1] = payload.try_into().ok()?;
        Some(Self { reason: p[0] })
    }
}

/// Jerk-limited stop, then latch. Idempotent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stop {
    /// As in EmergencyStop.
    pub reason: u8,
}

impl Message for Stop {
    const ID: u16 = 0x010;
    const LENGTH: usize = 1;

    fn write(&self, out: &mut [u8; 8]) {
        let b0 = self.reason;
        *out = [b0, 0, 0, 0, 0, 0, 0, 0];
    }

    fn read(payload: &[u8]) -> Option<Self> {
        let p: &[u8; 1] = payload.try_into().ok()?;
        Some(Self { reason: p[0] })
    }
}

/// Arm or re-arm, edge-triggered: acts only when token is later than every token seen before, so that a
/// late copy does nothing. Refused (fault counted) from another session or wire than the last Hello that
/// was accepted, with the emergency-stop input active, with the battery too low, or without a sensor that
/// driving needs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Arm {
    /// State.arm_token plus 1; compared in serial-number order: later by 1 to 32767.
    pub token: u16,
    /// That of the Hello.
    pub session: u16,
}

impl Message for Arm {
    const ID: u16 = 0x018;
    const LENGTH: usize = 4;

    fn write(&self, out: &mut [u8; 8]) {
        let [b0, b1] = self.token.to_le_bytes();
        let [b2, b3] = self.session.to_le_bytes();
        *out = [b0, b1, b2, b3, 0, 0, 0, 0];
    }

    fn read(payload: &[u8]) -> Option<Self> {
        let p: &[u8; 4] = payload.try_into().ok()?;
        Some(Self {
            token: u16::from_le_bytes([p[0], p[1]]),
            session: u16::from_le_bytes([p[2], p[3]]),
        })
    }
}

/// Stop jerk-limited, then switch the motors off without a latch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Disarm {
    /// As in EmergencyStop.
    pub reason: u8,
}

impl Message for Disarm {
    const ID: u16 = 0x019;
    const LENGTH: usize = 1;

    fn write(&self, out: &mut [u8; 8]) {
        let b0 = self.reason;
        *out = [b0, 0, 0, 0, 0, 0, 0, 0];
    }

    fn read(payload: &[u8]) -> Option<Self> {
        let p: &[u8; 1] = payload.try_into().ok()?;
        Some(Self { reason: p[0] })
    }
}

/// Feeds the dead-man while no motion is streamed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct KeepAlive {
    /// Counts up, so that a stuck sender is seen: one that is not later by 1 to 127 does not feed.
    pub counter: u8,
}

impl Message for KeepAlive {
    const ID: u16 = 0x020;
    const LENGTH: usize = 1;

    fn write(&self, out: &mut [u8; 8]) {
        let b0 = self.counter;
        *out = [b0, 0, 0, 0, 0, 0, 0, 0];
    }

    fn read(payload: &[u8]) -> Option<Self> {
        let p: &[u8; 1] = payload.try_into().ok()?;
        Some(Self { counter: p[0] })
    }
}

/// Asks for the firmware's clock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ClockRequest {
    /// Echoed in the reply.
    pub sequence: u8,
}

impl Message for ClockRequest {
    const ID: u16 = 0x030;
    const LENGTH: usize = 1;

    fn write(&self, out: &mut [u8; 8]) {
        let b0 = self.sequence;
        *out = [b0, 0, 0, 0, 0, 0, 0, 0];
    }

    fn read(payload: &[u8]) -> Option<Self> {
        let p: &[u8; 1] = payload.try_into().ok()?;
        Some(Self { sequence: p[0] })
    }
}

/// Answer to ClockRequest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ClockReply {
    /// Of the request.
    pub sequence: u8,
    /// In 1e-06 s; firmware clock when the request's last byte came in, wraps after 71.6 min.
    pub receive_time: u32,
    /// In 1e-06 s; from there until the reply was queued on the wire.
    pub turnaround: u16,
}

impl Message for ClockReply {
    const ID: u16 = 0x031;
    const LENGTH: usize = 7;

    fn write(&self, out: &mut [u8; 8]) {
        let b0 = self.sequence;
        let [b1, b2, b3, b4] = self.receive_time.to_le_bytes();
        let [b5, b6] = self.turnaround.to_le_bytes();
        *out = [b0, b1, b2, b3, b4, b5, b6, 0];
    }

    fn read(payload: &[u8]) -> Option<Self> {
        let p: &[u8; 7] = payload.try_into().ok()?;
        Some(Self {
            sequence: p[0],
            receive_time: u32::from_le_bytes([p[1], p[2], p[3], p[4]]),
            turnaround: u16::from_le_bytes([p[5], p[6]]),
        })
    }
}

/// First half of a constant-jerk segment: how long, and the jerk of travel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SegmentTravel {
    /// Counts up by one per segment, wraps.
    pub index: u16,
    /// In 1e-06 s; up to 16.7 s, at least 1 ms.
    pub duration: u32,
    /// In 1e-06 m/s^3; +-8.388607.
    pub jerk_travel: i32,
}

impl Message for SegmentTravel {
    const ID: u16 = 0x040;
    const LENGTH: usize = 8;

    fn write(&self, out: &mut [u8; 8]) {
        let [b0, b1] = self.index.to_le_bytes();
        let [b2, b3, b4, _] = self.duration.to_le_bytes();
        let [b5, b6, b7, _] = self.jerk_travel.to_le_bytes();
        *out = [b0, b1, b2, b3, b4, b5, b6, b7];
    }

    fn read(payload: &[u8]) -> Option<Self> {
        let p: &[u8; 8] = payload.try_into().ok()?;
        Some(Self {
            index: u16::from_le_bytes([p[0], p[1]]),
            duration: u32::from_le_bytes([p[2], p[3], p[4], 0]),
            jerk_travel: i32::from_le_bytes([0, p[5], p[6], p[7]]) >> 8,
        })
    }
}

/// Second half: the jerk of heading, and how the segment joins its neighbours. The segment is accepted when
/// both halves of the next expected index are there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SegmentHeading {
    /// Same as in SegmentTravel.
    pub index: u16,
    /// In 1e-06 rad/s^3; +-8.388607.
    pub jerk_heading: i32,
    /// Bit 0 begin: starts from rest at the time given by SegmentStart; bit 1 rest: velocity and
    /// acceleration are exactly zero at its end.
    pub flags: u8,
}

impl Message for SegmentHeading {
    const ID: u16 = 0x041;
    const LENGTH: usize = 6;

    fn write(&self, out: &mut [u8; 8]) {
        let [b0, b1] = self.index.to_le_bytes();
        let [b2, b3, b4, _] = self.jerk_heading.to_le_bytes();
        let b5 = self.flags;
        *out = [b0, b1, b2, b3, b4, b5, 0, 0];
    }

    fn read(payload: &[u8]) -> Option<Self> {
        let p: &[u8; 6] = payload.try_into().ok()?;
        Some(Self {
            index: u16::from_le_bytes([p[0], p[1]]),
            jerk_heading: i32::from_le_bytes([0, p[2], p[3], p[4]]) >> 8,
            flags: p[5],
        })
    }
}

/// When the run that begins with this index starts. Must arrive before the begin segment is complete.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SegmentStart {
    /// Of the begin segment.
    pub index: u16,
    /// In 1e-06 s; firmware clock; refused when in the past or more than 10 s ahead.
    pub start_time: u32,
}

impl Message for SegmentStart {
    const ID: u16 = 0x042;
    const LENGTH: usize = 6;

    fn write(&self, out: &mut [u8; 8]) {
        let [b0, b1] = self.index.to_le_bytes();
        let [b2, b3, b4, b5] = self.start_time.to_le_bytes();
        *out = [b0, b1, b2, b3, b4, b5, 0, 0];
    }

    fn read(payload: &[u8]) -> Option<Self> {
        let p: &[u8; 6] = payload.try_into().ok()?;
        Some(Self {
            index: u16::from_le_bytes([p[0], p[1]]),
            start_time: u32::from_le_bytes([p[2], p[3], p[4], p[5]]),
        })
    }
}

/// Acknowledges segments and tells the room left. Sent after every segment received and at the telemetry
/// rate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MotionStatus {
    /// The next index that the firmware expects.
    pub next_index: u16,
    /// Room in the queue.
    pub free_slots: u8,
    /// Segments waiting or running.
    pub queued: u8,
    /// Index that runs now, or the last that ran.
    pub executing: u16,
    /// Segments refused since boot, saturates.
    pub rejected: u16,
}

impl Message for MotionStatus {
    const ID: u16 = 0x050;
    const LENGTH: usize = 8;

    fn write(&self, out: &mut [u8; 8]) {
        let [b0, b1] = self.next_index.to_le_bytes();
        let b2 = self.free_slots;
        let b3 = self.queued;
        let [b4, b5] = self.executing.to_le_bytes();
        let [b6, b7] = self.rejected.to_le_bytes();
        *out = [b0, b1, b2, b3, b4, b5, b6, b7];
    }

    fn read(payload: &[u8]) -> Option<Self> {
        let p: &[u8; 8] = payload.try_into().ok()?;
        Some(Self {
            next_index: u16::from_le_bytes([p[0], p[1]]),
            free_slots: p[2],
            queued: p[3],
            executing: u16::from_le_bytes([p[4], p[5]]),
            rejected: u16::from_le_bytes([p[6], p[7]]),
        })
    }
}

/// Heartbeat of the firmware; once a second on a CAN bus on which no companion speaks to it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct State {
    /// 0 Boot, 1 Disarmed, 2 Armed, 3 Moving, 4 Stopping, 5 Latched.
    pub state: u8,
    /// Why it last stopped; 0 None, 1 StopCommand, 2 EmergencyCommand, 3 EmergencyInput, 4 DeadMan, 5
    /// SonarGuard, 6 LowBattery, 7 Stall, 8 EncoderFault, 9 Underrun, 10 Disarm, 11 Internal, 12
    /// InjectorSilent, 13 SensorLost, 14 Bumper.
    pub cause: u8,
    /// Reason byte of a stop command, or the number of the sensor or wheel.
    pub cause_detail: u8,
    /// Bit set of active faults with a code below 16.
    pub faults: u16,
    /// The latest token seen.
    pub arm_token: u16,
    /// Bit 0 handshake done; bit 1 emergency-stop input active; bit 2 moving; bit 3 motors powered; bit 4
    /// test mode: the bridges are off whatever bit 3 says; bit 5 a bumper switch is pressed.
    pub flags: u8,
}

impl Message for State {
    const ID: u16 = 0x060;
    const LENGTH: usize = 8;

    fn write(&self, out: &mut [u8; 8]) {
        let b0 = self.state;
        let b1 = self.cause;
        let b2 = self.cause_detail;
        let [b3, b4] = self.faults.to_le_bytes();
        let [b5, b6] = self.arm_token.to_le_bytes();
        let b7 = self.flags;
        *out = [b0, b1, b2, b3, b4, b5, b6, b7];
    }

    fn read(payload: &[u8]) -> Option<Self> {
        let p: &[u8; 8] = payload.try_into().ok()?;
        Some(Self {
            state: p[0],
            cause: p[1],
            cause_detail: p[2],
            faults: u16::from_le_bytes([p[3], p[4]]),
            arm_token: u16::from_le_bytes([p[5], p[6]]),
            flags: p[7],
        })
    }
}

/// Values of `State::state`.
pub mod state_state {
    /// Boot.
    pub const BOOT: u8 = 0;
    /// Disarmed.
    pub const DISARMED: u8 = 1;
    /// Armed.
    pub const ARMED: u8 = 2;
    /// Moving.
    pub const MOVING: u8 = 3;
    /// Stopping.
    pub const STOPPING: u8 = 4;
    /// Latched.
    pub const LATCHED: u8 = 5;
}

/// Values of `State::cause`.
pub mod state_cause {
    /// None.
    pub const NONE: u8 = 0;
    /// StopCommand.
    pub const STOP_COMMAND: u8 = 1;
    /// EmergencyCommand.
    pub const EMERGENCY_COMMAND: u8 = 2;
    /// EmergencyInput.
    pub const EMERGENCY_INPUT: u8 = 3;
    /// DeadMan.
    pub const DEAD_MAN: u8 = 4;
    /// SonarGuard.
    pub const SONAR_GUARD: u8 = 5;
    /// LowBattery.
    pub const LOW_BATTERY: u8 = 6;
    /// Stall.
    pub const STALL: u8 = 7;
    /// EncoderFault.
    pub const ENCODER_FAULT: u8 = 8;
    /// Underrun.
    pub const UNDERRUN: u8 = 9;
    /// Disarm.
    pub const DISARM: u8 = 10;
    /// Internal.
    pub const INTERNAL: u8 = 11;
    /// InjectorSilent.
    pub const INJECTOR_SILENT: u8 = 12;
    /// SensorLost.
    pub const SENSOR_LOST: u8 = 13;
    /// Bumper.
    pub const BUMPER: u8 = 14;
}

/// Quadrature counts, x4.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WheelTicks {
    /// In 0.001 s; firmware clock in ms, low 16 bits.
    pub time: u16,
    /// In count; cumulative, wraps.
    pub left: i32,
    /// In count; cumulative, wraps.
    pub right: i32,
}

impl Message for WheelTicks {
    const ID: u16 = 0x070;
    const LENGTH: usize = 8;

    fn write(&self, out: &mut [u8; 8]) {
        let [b0, b1] = self.time.to_le_bytes();
        let [b2, b3, b4, _] = self.left.to_le_bytes();
        let [b5, b6, b7, _] = self.right.to_le_bytes();
        *out = [b0, b1, b2, b3, b4, b5, b6, b7];
    }

    fn read(payload: &[u8]) -> Option<Self> {
        let p: &[u8; 8] = payload.try_into().ok()?;
        Some(Self {
            time: u16::from_le_bytes([p[0], p[1]]),
            left: i32::from_le_bytes([0, p[2], p[3], p[4]]) >> 8,
            right: i32::from_le_bytes([0, p[5], p[6], p[7]]) >> 8,
        })
    }
}

/// Dead-reckoned position since boot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OdometryPosition {
    /// In 1e-05 m.
    pub x: i32,
    /// In 1e-05 m.
    pub y: i32,
}

impl Message for OdometryPosition {
    const ID: u16 = 0x071;
    const LENGTH: usize = 8;

    fn write(&self, out: &mut [u8; 8]) {
        let [b0, b1, b2, b3] = self.x.to_le_bytes();
        let [b4, b5, b6, b7] = self.y.to_le_bytes();
        *out = [b0, b1, b2, b3, b4, b5, b6, b7];
    }

    fn read(payload: &[u8]) -> Option<Self> {
        let p: &[u8; 8] = payload.try_into().ok()?;
        Some(Self {
            x: i32::from_le_bytes([p[0], p[1], p[2], p[3]]),
            y: i32::from_le_bytes([p[4], p[5], p[6], p[7]]),
        })
    }
}

/// Dead-reckoned heading since boot, with the time of both odometry messages.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OdometryHeading {
    /// In 1e-06 rad; counts whole turns; wraps every 4294.967296 rad.
    pub heading: i32,
    /// In 1e-06 s; firmware clock.
    pub time: u32,
}

impl Message for OdometryHeading {
    const ID: u16 = 0x072;
    const LENGTH: usize = 8;

    fn write(&self, out: &mut [u8; 8]) {
        let [b0, b1, b2, b3] = self.heading.to_le_bytes();
        let [b4, b5, b6, b7] = self.time.to_le_bytes();
        *out = [b0, b1, b2, b3, b4, b5, b6, b7];
    }

    fn read(payload: &[u8]) -> Option<Self> {
        let p: &[u8; 8] = payload.try_into().ok()?;
        Some(Self {
            heading: i32::from_le_bytes([p[0], p[1], p[2], p[3]]),
            time: u32::from_le_bytes([p[4], p[5], p[6], p[7]]),
        })
    }
}

/// Reference and measured motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Velocity {
    /// In 0.0001 m/s.
    pub reference_travel: i16,
    /// In 0.001 rad/s.
    pub reference_heading: i16,
    /// In 0.0001 m/s.
    pub measured_travel: i16,
    /// In 0.001 rad/s.
    pub measured_heading: i16,
}

impl Message for Velocity {
    const ID: u16 = 0x073;
    const LENGTH: usize = 8;

    fn write(&self, out: &mut [u8; 8]) {
        let [b0, b1] = self.reference_travel.to_le_bytes();
        let [b2, b3] = self.reference_heading.to_le_bytes();
        let [b4, b5] = self.measured_travel.to_le_bytes();
        let [b6, b7] = self.measured_heading.to_le_bytes();
        *out = [b0, b1, b2, b3, b4, b5, b6, b7];
    }

    fn read(payload: &[u8]) -> Option<Self> {
        let p: &[u8; 8] = payload.try_into().ok()?;
        Some(Self {
            reference_travel: i16::from_le_bytes([p[0], p[1]]),
            reference_heading: i16::from_le_bytes([p[2], p[3]]),
            measured_travel: i16::from_le_bytes([p[4], p[5]]),
            measured_heading: i16::from_le_bytes([p[6], p[7]]),
        })
    }
}

/// Where along the commanded motion the firmware is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ReferenceDistance {
    /// In 1e-05 m; sum since boot.
    pub travel: i32,
    /// In 1e-06 rad; sum since boot; wraps every 4294.967296 rad.
    pub heading: i32,
}

impl Message for ReferenceDistance {
    const ID: u16 = 0x074;
    const LENGTH: usize = 8;

    fn write(&self, out: &mut [u8; 8]) {
        let [b0, b1, b2, b3] = self.travel.to_le_bytes();
        let [b4, b5, b6, b7] = self.heading.to_le_bytes();
        *out = [b0, b1, b2, b3, b4, b5, b6, b7];
    }

    fn read(payload: &[u8]) -> Option<Self> {
        let p: &[u8; 8] = payload.try_into().ok()?;
        Some(Self {
            travel: i32::from_le_bytes([p[0], p[1], p[2], p[3]]),
            heading: i32::from_le_bytes([p[4], p[5], p[6], p[7]]),
        })
    }
}

/// What the gyroscope has turned by about the rover's vertical since it was heard first, its bias at rest
/// taken off. Sent while there is an inertial sensor that can be believed; a gap longer than 30 ms means
/// that turns are missing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct InertialHeading {
    /// In 1e-06 rad; counts whole turns; wraps every 4294.967296 rad.
    pub heading: i32,
    /// In 0.001 rad/s; of the last sample.
    pub rate: i16,
    /// In 0.001 s; firmware clock in ms, low 16 bits.
    pub time: u16,
}

impl Message for InertialHeading {
    const ID: u16 = 0x075;
    const LENGTH: usize = 8;

    fn write(&self, out: &mut [u8; 8]) {
        let [b0, b1, b2, b3] = self.heading.to_le_bytes();
        let [b4, b5] = self.rate.to_le_bytes();
        let [b6, b7] = self.time.to_le_bytes();
        *out = [b0, b1, b2, b3, b4, b5, b6, b7];
    }

    fn read(payload: &[u8]) -> Option<Self> {
        let p: &[u8; 8] = payload.try_into().ok()?;
        Some(Self {
            heading: i32::from_le_bytes([p[0], p[1], p[2], p[3]]),
            rate: i16::from_le_bytes([p[4], p[5]]),
            time: u16::from_le_bytes([p[6], p[7]]),
        })
    }
}

/// Which way is up on base_link, as a rover at rest would feel it: 9.81 m/s^2 along z when it stands level.
/// Sent once there has been an inertial sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Gravity {
    /// In 0.001 m/s^2.
    pub x: i16,
    /// In 0.001 m/s^2.
    pub y: i16,
    /// In 0.001 m/s^2.
    pub z: i16,
    /// In 0.1 m/s^2; greatest difference between what was felt and that since the last of these messages,
    /// saturates.
    pub shake: u8,
    /// 0 Settling, 1 Good, 2 Lost.
    pub status: u8,
}

impl Message for Gravity {
    const ID: u16 = 0x076;
    const LENGTH: usize = 8;

    fn write(&self, out: &mut [u8; 8]) {
        let [b0, b1] = self.x.to_le_bytes();
        let [b2, b3] = self.y.to_le_bytes();
        let [b4, b5] = self.z.to_le_bytes();
        let b6 = self.shake;
        let b7 = self.status;
        *out = [b0, b1, b2, b3, b4, b5, b6, b7];
    }

    fn read(payload: &[u8]) -> Option<Self> {
        let p: &[u8; 8] = payload.try_into().ok()?;
        Some(Self {
            x: i16::from_le_bytes([p[0], p[1]]),
            y: i16::from_le_bytes([p[2], p[3]]),
            z: i16::from_le_bytes([p[4], p[5]]),
            shake: p[6],
            status: p[7],
        })
    }
}

/// Values of `Gravity::status`.
pub mod gravity_status {
    /// Settling.
    pub const SETTLING: u8 = 0;
    /// Good.
    pub const GOOD: u8 = 1;
    /// Lost.
    pub const LOST: u8 = 2;
}

/// One ultrasonic ranging.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sonar {
    /// 0 left, 1 centre, 2 right.
    pub sensor: u8,
    /// 0 Ok, 1 NoEcho, 2 Dead.
    pub status: u8,
    /// In 0.001 m; median-filtered; 65.535 when there was no echo.
    pub range: u16,
    /// In 1e-06 s; firmware clock at the ping.
    pub time: u32,
}

impl Message for Sonar {
    const ID: u16 = 0x080;
    const LENGTH: usize = 8;

    fn write(&self, out: &mut [u8; 8]) {
        let b0 = self.sensor;
        let b1 = self.status;
        let [b2, b3] = self.range.to_le_bytes();
        let [b4, b5, b6, b7] = self.time.to_le_bytes();
        *out = [b0, b1, b2, b3, b4, b5, b6, b7];
    }

    fn read(payload: &[u8]) -> Option<Self> {
        let p: &[u8; 8] = payload.try_into().ok()?;
        Some(Self {
            sensor: p[0],
            status: p[1],
            range: u16::from_le_bytes([p[2], p[3]]),
            time: u32::from_le_bytes([p[4], p[5], p[6], p[7]]),
        })
    }
}

/// Values of `Sonar::status`.
pub mod sonar_status {
    /// Ok.
    pub const OK: u8 = 0;
    /// NoEcho.
    pub const NO_ECHO: u8 = 1;
    /// Dead.
    pub const DEAD: u8 = 2;
}

/// Battery.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Battery {
    /// In 0.001 V.
    pub voltage: u16,
    /// In 0.001 V; lowest since boot.
    pub minimum: u16,
}

impl Message for Battery {
    const ID: u16 = 0x090;
    const LENGTH: usize = 4;

    fn write(&self, out: &mut [u8; 8]) {
        let [b0, b1] = self.voltage.to_le_bytes();
        let [b2, b3] = self.minimum.to_le_bytes();
        *out = [b0, b1, b2, b3, 0, 0, 0, 0];
    }

    fn read(payload: &[u8]) -> Option<Self> {
        let p: &[u8; 4] = payload.try_into().ok()?;
        Some(Self {
            voltage: u16::from_le_bytes([p[0], p[1]]),
            minimum: u16::from_le_bytes([p[2], p[3]]),
        })
    }
}

/// Duty of both motors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MotorDuty {
    /// In 3.051757812e-05; -1 to 1.
    pub left: i16,
    /// In 3.051757812e-05; -1 to 1.
    pub right: i16,
}

impl Message for MotorDuty {
    const ID: u16 = 0x091;
    const LENGTH: usize = 4;

    fn write(&self, out: &mut [u8; 8]) {
        let [b0, b1] = self.left.to_le_bytes();
        let [b2, b3] = self.right.to_le_bytes();
        *out = [b0, b1, b2, b3, 0, 0, 0, 0];
    }

    fn read(payload: &[u8]) -> Option<Self> {
        let p: &[u8; 4] = payload.try_into().ok()?;
        Some(Self {
            left: i16::from_le_bytes([p[0], p[1]]),
            right: i16::from_le_bytes([p[2], p[3]]),
        })
    }
}

/// A fault has come or its counter has changed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Fault {
    /// 0 None, 1 DeadMan, 2 SonarGuard, 3 LowBattery, 4 Stall, 5 EncoderLeft, 6 EncoderRight, 7 SonarDead,
    /// 8 Underrun, 9 SegmentRejected, 10 ArmRefused, 11 QueueFull, 12 TransmitOverflow, 13 ReceiveOverflow,
    /// 14 SchemaMismatch, 15 Watchdog, 16 InertialLost.
    pub code: u8,
    /// Active.
    pub active: u8,
    /// Since boot, saturates.
    pub count: u16,
    /// Depends on the code.
    pub detail: u32,
}

impl Message for Fault {
    const ID: u16 = 0x0a0;
    const LENGTH: usize = 8;

    fn write(&self, out: &mut [u8; 8]) {
        let b0 = self.code;
        let b1 = self.active;
        let [b2, b3] = self.count.to_le_bytes();
        let [b4, b5, b6, b7] = self.detail.to_le_bytes();
        *out = [b0, b1, b2, b3, b4, b5, b6, b7];
    }

    fn read(payload: &[u8]) -> Option<Self> {
        let p: &[u8; 8] = payload.try_into().ok()?;
        Some(Self {
            code: p[0],
            active: p[1],
            count: u16::from_le_bytes([p[2], p[3]]),
            detail: u32::from_le_bytes([p[4], p[5], p[6], p[7]]),
        })
    }
}

/// Values of `Fault::code`.
pub mod fault_code {
    /// None.
    pub const NONE: u8 = 0;
    /// DeadMan.
    pub const DEAD_MAN: u8 = 1;
    /// SonarGuard.
    pub const SONAR_GUARD: u8 = 2;
    /// LowBattery.
    pub const LOW_BATTERY: u8 = 3;
    /// Stall.
    pub const STALL: u8 = 4;
    /// EncoderLeft.
    pub const ENCODER_LEFT: u8 = 5;
    /// EncoderRight.
    pub const ENCODER_RIGHT: u8 = 6;
    /// SonarDead.
    pub const SONAR_DEAD: u8 = 7;
    /// Underrun.
    pub const UNDERRUN: u8 = 8;
    /// SegmentRejected.
    pub const SEGMENT_REJECTED: u8 = 9;
    /// ArmRefused.
    pub const ARM_REFUSED: u8 = 10;
    /// QueueFull.
    pub const QUEUE_FULL: u8 = 11;
    /// TransmitOverflow.
    pub const TRANSMIT_OVERFLOW: u8 = 12;
    /// ReceiveOverflow.
    pub const RECEIVE_OVERFLOW: u8 = 13;
    /// SchemaMismatch.
    pub const SCHEMA_MISMATCH: u8 = 14;
    /// Watchdog.
    pub const WATCHDOG: u8 = 15;
    /// InertialLost.
    pub const INERTIAL_LOST: u8 = 16;
}

/// What the firmware's receiver has seen, since boot, wrapping.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LinkStatistics {
    /// Good frames.
    pub frames: u16,
    /// Checksum errors.
    pub checksum_errors: u16,
    /// Wrong length, unknown identifier, COBS error.
    pub malformed: u16,
    /// Gaps in the sequence byte.
    pub lost: u16,
}

impl Message for LinkStatistics {
    const ID: u16 = 0x0a1;
    const LENGTH: usize = 8;

    fn write(&self, out: &mut [u8; 8]) {
        let [b0, b1] = self.frames.to_le_bytes();
        let [b2, b3] = self.checksum_errors.to_le_bytes();
        let [b4, b5] = self.malformed.to_le_bytes();
        let [b6, b7] = self.lost.to_le_bytes();
        *out = [b0, b1, b2, b3, b4, b5, b6, b7];
    }

    fn read(payload: &[u8]) -> Option<Self> {
        let p: &[u8; 8] = payload.try_into().ok()?;
        Some(Self {
            frames: u16::from_le_bytes([p[0], p[1]]),
            checksum_errors: u16::from_le_bytes([p[2], p[3]]),
            malformed: u16::from_le_bytes([p[4], p[5]]),
            lost: u16::from_le_bytes([p[6], p[7]]),
        })
    }
}

/// A piece of a log line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LogText {
    /// Position of the piece in its line; the line ends with a zero byte.
    pub offset: u8,
    /// UTF-8, zero-padded.
    pub text: [u8; 7],
}

impl Message for LogText {
    const ID: u16 = 0x0b0;
    const LENGTH: usize = 8;

    fn write(&self, out: &mut [u8; 8]) {
        let b0 = self.offset;
        let [b1, b2, b3, b4, b5, b6, b7] = self.text;
        *out = [b0, b1, b2, b3, b4, b5, b6, b7];
    }

    fn read(payload: &[u8]) -> Option<Self> {
        let p: &[u8; 8] = payload.try_into().ok()?;
        Some(Self {
            offset: p[0],
            text: [p[1], p[2], p[3], p[4], p[5], p[6], p[7]],
        })
    }
}

/// Handshake.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Hello {
    /// CRC-32 of the normalised rover.dbc; a mismatch is answered and refused.
    pub schema_hash: u32,
    /// Random number of the companion's session.
    pub session: u16,
}

impl Message for Hello {
    const ID: u16 = 0x100;
    const LENGTH: usize = 6;

    fn write(&self, out: &mut [u8; 8]) {
        let [b0, b1, b2, b3] = self.schema_hash.to_le_bytes();
        let [b4, b5] = self.session.to_le_bytes();
        *out = [b0, b1, b2, b3, b4, b5, 0, 0];
    }

    fn read(payload: &[u8]) -> Option<Self> {
        let p: &[u8; 6] = payload.try_into().ok()?;
        Some(Self {
            schema_hash: u32::from_le_bytes([p[0], p[1], p[2], p[3]]),
            session: u16::from_le_bytes([p[4], p[5]]),
        })
    }
}

/// Answer to Hello.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct HelloReply {
    /// Schema hash.
    pub schema_hash: u32,
    /// Version major.
    pub version_major: u8,
    /// Version minor.
    pub version_minor: u8,
    /// Version patch.
    pub version_patch: u8,
    /// 0 Sitl, 1 Rp2040, 2 Rp2350, 3 MicroPython.
    pub board: u8,
}

impl Message for HelloReply {
    const ID: u16 = 0x101;
    const LENGTH: usize = 8;

    fn write(&self, out: &mut [u8; 8]) {
        let [b0, b1, b2, b3] = self.schema_hash.to_le_bytes();
        let b4 = self.version_major;
        let b5 = self.version_minor;
        let b6 = self.version_patch;
        let b7 = self.board;
        *out = [b0, b1, b2, b3, b4, b5, b6, b7];
    }

    fn read(payload: &[u8]) -> Option<Self> {
        let p: &[u8; 8] = payload.try_into().ok()?;
        Some(Self {
            schema_hash: u32::from_le_bytes([p[0], p[1], p[2], p[3]]),
            version_major: p[4],
            version_minor: p[5],
            version_patch: p[6],
            board: p[7],
        })
    }
}

/// Values of `HelloReply::board`.
pub mod hello_reply_board {
    /// Sitl.
    pub const SITL: u8 = 0;
    /// Rp2040.
    pub const RP2040: u8 = 1;
    /// Rp2350.
    pub const RP2350: u8 = 2;
    /// MicroPython.
    pub const MICRO_PYTHON: u8 = 3;
}

/// Second answer to Hello.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct HelloBuild {
    /// First 32 bits of the commit.
    pub git_hash: u32,
    /// 0 PowerOn, 1 Watchdog, 2 Software, 3 BrownOut, 4 Unknown.
    pub reset_cause: u8,
    /// 1 when the schema hashes agree and the session is yours.
    pub accepted: u8,
    /// Echoed.
    pub session: u16,
}

impl Message for HelloBuild {
    const ID: u16 = 0x102;
    const LENGTH: usize = 8;

    fn write(&self, out: &mut [u8; 8]) {
        let [b0, b1, b2, b3] = self.git_hash.to_le_bytes();
        let b4 = self.reset_cause;
        let b5 = self.accepted;
        let [b6, b7] = self.session.to_le_bytes();
        *out = [b0, b1, b2, b3, b4, b5, b6, b7];
    }

    fn read(payload: &[u8]) -> Option<Self> {
        let p: &[u8; 8] = payload.try_into().ok()?;
        Some(Self {
            git_hash: u32::from_le_bytes([p[0], p[1], p[2], p[3]]),
            reset_cause: p[4],
            accepted: p[5],
            session: u16::from_le_bytes([p[6], p[7]]),
        })
    }
}

/// Values of `HelloBuild::reset_cause`.
pub mod hello_build_reset_cause {
    /// PowerOn.
    pub const POWER_ON: u8 = 0;
    /// Watchdog.
    pub const WATCHDOG: u8 = 1;
    /// Software.
    pub const SOFTWARE: u8 = 2;
    /// BrownOut.
    pub const BROWN_OUT: u8 = 3;
    /// Unknown.
    pub const UNKNOWN: u8 = 4;
}

/// Answer to Hello, on the wire that it came by: another session drives the rover and keeps it until the
/// motors are off.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct HelloBusy {
    /// Echoed.
    pub session: u16,
    /// Session that drives.
    pub holder: u16,
    /// That it is connected by; 0 Serial, 1 Can.
    pub wire: u8,
}

impl Message for HelloBusy {
    const ID: u16 = 0x103;
    const LENGTH: usize = 5;

    fn write(&self, out: &mut [u8; 8]) {
        let [b0, b1] = self.session.to_le_bytes();
        let [b2, b3] = self.holder.to_le_bytes();
        let b4 = self.wire;
        *out = [b0, b1, b2, b3, b4, 0, 0, 0];
    }

    fn read(payload: &[u8]) -> Option<Self> {
        let p: &[u8; 5] = payload.try_into().ok()?;
        Some(Self {
            session: u16::from_le_bytes([p[0], p[1]]),
            holder: u16::from_le_bytes([p[2], p[3]]),
            wire: p[4],
        })
    }
}

/// Values of `HelloBusy::wire`.
pub mod hello_busy_wire {
    /// Serial.
    pub const SERIAL: u8 = 0;
    /// Can.
    pub const CAN: u8 = 1;
}

/// Asks for a parameter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ParameterGet {
    /// Identifier.
    pub identifier: u16,
}

impl Message for ParameterGet {
    const ID: u16 = 0x110;
    const LENGTH: usize = 2;

    fn write(&self, out: &mut [u8; 8]) {
        let [b0, b1] = self.identifier.to_le_bytes();
        *out = [b0, b1, 0, 0, 0, 0, 0, 0];
    }

    fn read(payload: &[u8]) -> Option<Self> {
        let p: &[u8; 2] = payload.try_into().ok()?;
        Some(Self {
            identifier: u16::from_le_bytes([p[0], p[1]]),
        })
    }
}

/// Sets a parameter in memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ParameterSet {
    /// Identifier.
    pub identifier: u16,
    /// In the parameter's own unit, see docs/reference/protocol.md.
    pub value: i32,
}

impl Message for ParameterSet {
    const ID: u16 = 0x111;
    const LENGTH: usize = 6;

    fn write(&self, out: &mut [u8; 8]) {
        let [b0, b1] = self.identifier.to_le_bytes();
        let [b2, b3, b4, b5] = self.value.to_le_bytes();
        *out = [b0, b1, b2, b3, b4, b5, 0, 0];
    }

    fn read(payload: &[u8]) -> Option<Self> {
        let p: &[u8; 6] = payload.try_into().ok()?;
        Some(Self {
            identifier: u16::from_le_bytes([p[0], p[1]]),
            value: i32::from_le_bytes([p[2], p[3], p[4], p[5]]),
        })
    }
}

/// Answer to both.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ParameterValue {
    /// Identifier.
    pub identifier: u16,
    /// Value.
    pub value: i32,
    /// 0 Ok, 1 UnknownParameter, 2 OutOfRange, 3 RefusedWhileArmed, 4 StorageError.
    pub status: u8,
}

impl Message for ParameterValue {
    const ID: u16 = 0x112;
    const LENGTH: usize = 7;

    fn write(&self, out: &mut [u8; 8]) {
        let [b0, b1] = self.identifier.to_le_bytes();
        let [b2, b3, b4, b5] = self.value.to_le_bytes();
        let b6 = self.status;
        *out = [b0, b1, b2, b3, b4, b5, b6, 0];
    }

    fn read(payload: &[u8]) -> Option<Self> {
        let p: &[u8; 7] = payload.try_into().ok()?;
        Some(Self {
            identifier: u16::from_le_bytes([p[0], p[1]]),
            value: i32::from_le_bytes([p[2], p[3], p[4], p[5]]),
            status: p[6],
        })
    }
}

/// Values of `ParameterValue::status`.
pub mod parameter_value_status {
    /// Ok.
    pub const OK: u8 = 0;
    /// UnknownParameter.
    pub const UNKNOWN_PARAMETER: u8 = 1;
    /// OutOfRange.
    pub const OUT_OF_RANGE: u8 = 2;
    /// RefusedWhileArmed.
    pub const REFUSED_WHILE_ARMED: u8 = 3;
    /// StorageError.
    pub const STORAGE_ERROR: u8 = 4;
}

/// Save all parameters, or go back to defaults.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ParameterCommand {
    /// 0 Save, 1 Defaults, 2 Load.
    pub command: u8,
}

impl Message for ParameterCommand {
    const ID: u16 = 0x113;
    const LENGTH: usize = 1;

    fn write(&self, out: &mut [u8; 8]) {
        let b0 = self.command;
        *out = [b0, 0, 0, 0, 0, 0, 0, 0];
    }

    fn read(payload: &[u8]) -> Option<Self> {
        let p: &[u8; 1] = payload.try_into().ok()?;
        Some(Self { command: p[0] })
    }
}

/// Values of `ParameterCommand::command`.
pub mod parameter_command_command {
    /// Save.
    pub const SAVE: u8 = 0;
    /// Defaults.
    pub const DEFAULTS: u8 = 1;
    /// Load.
    pub const LOAD: u8 = 2;
}

/// Period of one telemetry message.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TelemetryRate {
    /// Identifier.
    pub message: u16,
    /// In 0.001 s; 0 switches it off.
    pub period: u16,
}

impl Message for TelemetryRate {
    const ID: u16 = 0x120;
    const LENGTH: usize = 4;

    fn write(&self, out: &mut [u8; 8]) {
        let [b0, b1] = self.message.to_le_bytes();
        let [b2, b3] = self.period.to_le_bytes();
        *out = [b0, b1, b2, b3, 0, 0, 0, 0];
    }

    fn read(payload: &[u8]) -> Option<Self> {
        let p: &[u8; 4] = payload.try_into().ok()?;
        Some(Self {
            message: u16::from_le_bytes([p[0], p[1]]),
            period: u16::from_le_bytes([p[2], p[3]]),
        })
    }
}

/// Sensors from the wire instead of the pins, motors off whatever the state. Refused while the motors are
/// on and before a matching Hello. Answered by State.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TestMode {
    /// 1 begins, 0 ends.
    pub enable: u8,
    /// 0x5445 to begin; not looked at to end.
    pub key: u16,
}

impl Message for TestMode {
    const ID: u16 = 0x130;
    const LENGTH: usize = 3;

    fn write(&self, out: &mut [u8; 8]) {
        let b0 = self.enable;
        let [b1, b2] = self.key.to_le_bytes();
        *out = [b0, b1, b2, 0, 0, 0, 0, 0];
    }

    fn read(payload: &[u8]) -> Option<Self> {
        let p: &[u8; 3] = payload.try_into().ok()?;
        Some(Self {
            enable: p[0],
            key: u16::from_le_bytes([p[1], p[2]]),
        })
    }
}

/// Quadrature counts in test mode.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct InjectWheels {
    /// In count; cumulative, wraps; the first ones are where the wheels stand.
    pub left: i32,
    /// In count; cumulative, wraps.
    pub right: i32,
}

impl Message for InjectWheels {
    const ID: u16 = 0x131;
    const LENGTH: usize = 8;

    fn write(&self, out: &mut [u8; 8]) {
        let [b0, b1, b2, b3] = self.left.to_le_bytes();
        let [b4, b5, b6, b7] = self.right.to_le_bytes();
        *out = [b0, b1, b2, b3, b4, b5, b6, b7];
    }

    fn read(payload: &[u8]) -> Option<Self> {
        let p: &[u8; 8] = payload.try_into().ok()?;
        Some(Self {
            left: i32::from_le_bytes([p[0], p[1], p[2], p[3]]),
            right: i32::from_le_bytes([p[4], p[5], p[6], p[7]]),
        })
    }
}

/// All other measurements in test mode.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct InjectSensors {
    /// In 0.001 V.
    pub battery: u16,
    /// Not 0: pressed; the real input counts as well.
    pub emergency_stop: u8,
    /// Sensor that the echo is for from now on: 0 left, 1 centre, 2 right; 255 none.
    pub sonar: u8,
    /// In 1e-06 s; length of its echo; 0 for a time-out, 16.777215 for a sensor that says nothing.
    pub echo: u32,
    /// Not 0: pressed; the real one does not count.
    pub bumper: u8,
}

impl Message for InjectSensors {
    const ID: u16 = 0x132;
    const LENGTH: usize = 8;

    fn write(&self, out: &mut [u8; 8]) {
        let [b0, b1] = self.battery.to_le_bytes();
        let b2 = self.emergency_stop;
        let b3 = self.sonar;
        let [b4, b5, b6, _] = self.echo.to_le_bytes();
        let b7 = self.bumper;
        *out = [b0, b1, b2, b3, b4, b5, b6, b7];
    }

    fn read(payload: &[u8]) -> Option<Self> {
        let p: &[u8; 8] = payload.try_into().ok()?;
        Some(Self {
            battery: u16::from_le_bytes([p[0], p[1]]),
            emergency_stop: p[2],
            sonar: p[3],
            echo: u32::from_le_bytes([p[4], p[5], p[6], 0]),
            bumper: p[7],
        })
    }
}

/// Asks for the record of the last crash, or clears it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CrashRequest {
    /// 1 is ignored while armed; both are answered by what the record is then; 0 Read, 1 Clear.
    pub command: u8,
}

impl Message for CrashRequest {
    const ID: u16 = 0x140;
    const LENGTH: usize = 1;

    fn write(&self, out: &mut [u8; 8]) {
        let b0 = self.command;
        *out = [b0, 0, 0, 0, 0, 0, 0, 0];
    }

    fn read(payload: &[u8]) -> Option<Self> {
        let p: &[u8; 1] = payload.try_into().ok()?;
        Some(Self { command: p[0] })
    }
}

/// Values of `CrashRequest::command`.
pub mod crash_request_command {
    /// Read.
    pub const READ: u8 = 0;
    /// Clear.
    pub const CLEAR: u8 = 1;
}

/// Answer to CrashRequest: what crashed. Cause None and nothing more when there is no record.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CrashCause {
    /// 0 None, 1 Panic, 2 HardFault, 3 Watchdog.
    pub cause: u8,
    /// That ran, or that had shown no life for longest; 0 Idle, 1 Control, 2 EmergencyStop, 3 Sonar, 4 Can,
    /// 5 Usb, 6 Life, 7 Link, 8 Battery, 9 Inertial.
    pub task: u8,
    /// Of a panic its line in the source, else 0.
    pub detail: u16,
    /// Of a hard fault the instruction that failed, of the watchdog the one that ran just before, of a
    /// panic the address of its core::panic::Location in the image; 0 when it is not known.
    pub program_counter: u32,
}

impl Message for CrashCause {
    const ID: u16 = 0x141;
    const LENGTH: usize = 8;

    fn write(&self, out: &mut [u8; 8]) {
        let b0 = self.cause;
        let b1 = self.task;
        let [b2, b3] = self.detail.to_le_bytes();
        let [b4, b5, b6, b7] = self.program_counter.to_le_bytes();
        *out = [b0, b1, b2, b3, b4, b5, b6, b7];
    }

    fn read(payload: &[u8]) -> Option<Self> {
        let p: &[u8; 8] = payload.try_into().ok()?;
        Some(Self {
            cause: p[0],
            task: p[1],
            detail: u16::from_le_bytes([p[2], p[3]]),
            program_counter: u32::from_le_bytes([p[4], p[5], p[6], p[7]]),
        })
    }
}

/// Values of `CrashCause::cause`.
pub mod crash_cause_cause {
    /// None.
    pub const NONE: u8 = 0;
    /// Panic.
    pub const PANIC: u8 = 1;
    /// HardFault.
    pub const HARD_FAULT: u8 = 2;
    /// Watchdog.
    pub const WATCHDOG: u8 = 3;
}

/// Values of `CrashCause::task`.
pub mod crash_cause_task {
    /// Idle.
    pub const IDLE: u8 = 0;
    /// Control.
    pub const CONTROL: u8 = 1;
    /// EmergencyStop.
    pub const EMERGENCY_STOP: u8 = 2;
    /// Sonar.
    pub const SONAR: u8 = 3;
    /// Can.
    pub const CAN: u8 = 4;
    /// Usb.
    pub const USB: u8 = 5;
    /// Life.
    pub const LIFE: u8 = 6;
    /// Link.
    pub const LINK: u8 = 7;
    /// Battery.
    pub const BATTERY: u8 = 8;
    /// Inertial.
    pub const INERTIAL: u8 = 9;
}

/// Second answer to CrashRequest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CrashTime {
    /// In 0.001 s; from the start to the crash.
    pub uptime: u32,
    /// In byte; most that the stack has held.
    pub stack: u16,
    /// How many follow.
    pub events: u8,
}

impl Message for CrashTime {
    const ID: u16 = 0x142;
    const LENGTH: usize = 7;

    fn write(&self, out: &mut [u8; 8]) {
        let [b0, b1, b2, b3] = self.uptime.to_le_bytes();
        let [b4, b5] = self.stack.to_le_bytes();
        let b6 = self.events;
        *out = [b0, b1, b2, b3, b4, b5, b6, 0];
    }

    fn read(payload: &[u8]) -> Option<Self> {
        let p: &[u8; 7] = payload.try_into().ok()?;
        Some(Self {
            uptime: u32::from_le_bytes([p[0], p[1], p[2], p[3]]),
            stack: u16::from_le_bytes([p[4], p[5]]),
            events: p[6],
        })
    }
}

/// One of the last events before the crash, the oldest first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CrashEvent {
    /// Counts from 0.
    pub index: u8,
    /// 0 None, 1 Start, 2 State, 3 Fault, 4 FaultOver, 5 Reboot.
    pub kind: u8,
    /// Of State its state and 256 times its cause, of a fault its code, of a start its reset cause.
    pub detail: u16,
    /// In 0.001 s; since the start.
    pub time: u32,
}

impl Message for CrashEvent {
    const ID: u16 = 0x143;
    const LENGTH: usize = 8;

    fn write(&self, out: &mut [u8; 8]) {
        let b0 = self.index;
        let b1 = self.kind;
        let [b2, b3] = self.detail.to_le_bytes();
        let [b4, b5, b6, b7] = self.time.to_le_bytes();
        *out = [b0, b1, b2, b3, b4, b5, b6, b7];
    }

    fn read(payload: &[u8]) -> Option<Self> {
        let p: &[u8; 8] = payload.try_into().ok()?;
        Some(Self {
            index: p[0],
            kind: p[1],
            detail: u16::from_le_bytes([p[2], p[3]]),
            time: u32::from_le_bytes([p[4], p[5], p[6], p[7]]),
        })
    }
}

/// Values of `CrashEvent::kind`.
pub mod crash_event_kind {
    /// None.
    pub const NONE: u8 = 0;
    /// Start.
    pub const START: u8 = 1;
    /// State.
    pub const STATE: u8 = 2;
    /// Fault.
    pub const FAULT: u8 = 3;
    /// FaultOver.
    pub const FAULT_OVER: u8 = 4;
    /// Reboot.
    pub const REBOOT: u8 = 5;
}

/// Restarts. Ignored while armed, while a wheel turns, and from another session or wire than the last
/// Hello, whatever its schema.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Reboot {
    /// 0x52424F54 restart, 0x424F4F54 into the bootloader.
    pub magic: u32,
    /// That of the Hello.
    pub session: u16,
}

impl Message for Reboot {
    const ID: u16 = 0x7f0;
    const LENGTH: usize = 6;

    fn write(&self, out: &mut [u8; 8]) {
        let [b0, b1, b2, b3] = self.magic.to_le_bytes();
        let [b4, b5] = self.session.to_le_bytes();
        *out = [b0, b1, b2, b3, b4, b5, 0, 0];
    }

    fn read(payload: &[u8]) -> Option<Self> {
        let p: &[u8; 6] = payload.try_into().ok()?;
        Some(Self {
            magic: u32::from_le_bytes([p[0], p[1], p[2], p[3]]),
            session: u16::from_le_bytes([p[4], p[5]]),
        })
    }
}
