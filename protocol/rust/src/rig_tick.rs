//! One millisecond between a simulated rig and its firmware, as bytes on a pair of pipes.
//!
//! Written by `python -m tools.generate`: change protocol/rig_tick.toml, not this file.

/// `echo_sensor` and `sonar_trigger` when there is none.
pub const NO_SENSOR: u8 = 255;
/// `host_bytes_due` of a rig that does not count: takes whatever is there.
pub const ALL_HOST_BYTES: u64 = 0xffffffffffffffff;
/// Bit of `flags`: the bridges are on.
pub const POWERED: u8 = 1;
/// Bit of `flags`: the lamp is lit.
pub const LED: u8 = 2;
/// Bit of `flags`: the buzzer sounds.
pub const BUZZER: u8 = 4;

/// What the firmware's peripherals read at a tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TickRequest {
    /// Time since the firmware's start, µs.
    pub now_us: u64,
    /// Quadrature counts, x4, forward positive, wrapping.
    pub encoder_left: i32,
    /// As for the left wheel.
    pub encoder_right: i32,
    /// Length of the echo that has ended by now, µs; 0 for a timeout.
    pub echo_us: u32,
    /// Battery at its terminals, mV.
    pub battery_mv: u16,
    /// Sonar that the echo belongs to; NO_SENSOR: none has ended.
    pub echo_sensor: u8,
    /// 1 while the emergency-stop input is active.
    pub emergency_stop: u8,
    /// Bytes of the host that must have come before this tick, in total.
    pub host_bytes_due: u64,
    /// 1 + the sonar that was triggered in the last tick; 0: none was.
    pub ping: u8,
    /// 1 while a switch of the bumper is pressed.
    pub bumper: u8,
    /// 1 while there is an inertial sensor that answers, 2 while it holds the bus.
    pub inertial: u8,
    /// Length of the echo that it is going to hear, µs; 0: none.
    pub ping_echo_us: u32,
    /// Rate about base_link's x as the sensor has it in its registers: 8.75 mdeg/s.
    pub gyro_x: i16,
    /// As for x.
    pub gyro_y: i16,
    /// As for x.
    pub gyro_z: i16,
    /// What it feels along base_link's x, likewise: 0.061 mg.
    pub acceleration_x: i16,
    /// As for x.
    pub acceleration_y: i16,
    /// As for x.
    pub acceleration_z: i16,
    /// Of the sensor, likewise: 1/256 K from 25 degrees Celsius.
    pub temperature: i16,
}

impl TickRequest {
    /// Bytes on the pipe.
    pub const SIZE: usize = 56;

    /// The bytes on the pipe.
    pub fn write(&self) -> [u8; Self::SIZE] {
        let mut out = [0; Self::SIZE];
        out[0..8].copy_from_slice(&self.now_us.to_le_bytes());
        out[8..12].copy_from_slice(&self.encoder_left.to_le_bytes());
        out[12..16].copy_from_slice(&self.encoder_right.to_le_bytes());
        out[16..20].copy_from_slice(&self.echo_us.to_le_bytes());
        out[20..22].copy_from_slice(&self.battery_mv.to_le_bytes());
        out[22] = self.echo_sensor;
        out[23] = self.emergency_stop;
        out[24..32].copy_from_slice(&self.host_bytes_due.to_le_bytes());
        out[32] = self.ping;
        out[33] = self.bumper;
        out[34] = self.inertial;
        out[36..40].copy_from_slice(&self.ping_echo_us.to_le_bytes());
        out[40..42].copy_from_slice(&self.gyro_x.to_le_bytes());
        out[42..44].copy_from_slice(&self.gyro_y.to_le_bytes());
        out[44..46].copy_from_slice(&self.gyro_z.to_le_bytes());
        out[46..48].copy_from_slice(&self.acceleration_x.to_le_bytes());
        out[48..50].copy_from_slice(&self.acceleration_y.to_le_bytes());
        out[50..52].copy_from_slice(&self.acceleration_z.to_le_bytes());
        out[52..54].copy_from_slice(&self.temperature.to_le_bytes());
        out
    }

    /// From the bytes on the pipe; every one of them is a record.
    pub fn read(b: &[u8; Self::SIZE]) -> Self {
        Self {
            now_us: u64::from_le_bytes([b[0], b[1], b[2], b[3], b[4], b[5], b[6], b[7]]),
            encoder_left: i32::from_le_bytes([b[8], b[9], b[10], b[11]]),
            encoder_right: i32::from_le_bytes([b[12], b[13], b[14], b[15]]),
            echo_us: u32::from_le_bytes([b[16], b[17], b[18], b[19]]),
            battery_mv: u16::from_le_bytes([b[20], b[21]]),
            echo_sensor: b[22],
            emergency_stop: b[23],
            host_bytes_due: u64::from_le_bytes([
                b[24], b[25], b[26], b[27], b[28], b[29], b[30], b[31],
            ]),
            ping: b[32],
            bumper: b[33],
            inertial: b[34],
            ping_echo_us: u32::from_le_bytes([b[36], b[37], b[38], b[39]]),
            gyro_x: i16::from_le_bytes([b[40], b[41]]),
            gyro_y: i16::from_le_bytes([b[42], b[43]]),
            gyro_z: i16::from_le_bytes([b[44], b[45]]),
            acceleration_x: i16::from_le_bytes([b[46], b[47]]),
            acceleration_y: i16::from_le_bytes([b[48], b[49]]),
            acceleration_z: i16::from_le_bytes([b[50], b[51]]),
            temperature: i16::from_le_bytes([b[52], b[53]]),
        }
    }
}

/// What the firmware's peripherals do until the next tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TickReply {
    /// Q15 as the bridge makes it: 32767 is full duty forward.
    pub duty_left: i16,
    /// As for the left motor.
    pub duty_right: i16,
    /// POWERED, LED, BUZZER.
    pub flags: u8,
    /// Sonar to ping now: 0 left, 1 centre, 2 right; or NO_SENSOR.
    pub sonar_trigger: u8,
    /// Bytes that the firmware has sent to the host, in total.
    pub bytes_sent: u64,
}

impl TickReply {
    /// Bytes on the pipe.
    pub const SIZE: usize = 16;

    /// The bytes on the pipe.
    pub fn write(&self) -> [u8; Self::SIZE] {
        let mut out = [0; Self::SIZE];
        out[0..2].copy_from_slice(&self.duty_left.to_le_bytes());
        out[2..4].copy_from_slice(&self.duty_right.to_le_bytes());
        out[4] = self.flags;
        out[5] = self.sonar_trigger;
        out[8..16].copy_from_slice(&self.bytes_sent.to_le_bytes());
        out
    }

    /// From the bytes on the pipe; every one of them is a record.
    pub fn read(b: &[u8; Self::SIZE]) -> Self {
        Self {
            duty_left: i16::from_le_bytes([b[0], b[1]]),
            duty_right: i16::from_le_bytes([b[2], b[3]]),
            flags: b[4],
            sonar_trigger: b[5],
            bytes_sent: u64::from_le_bytes([b[8], b[9], b[10], b[11], b[12], b[13], b[14], b[15]]),
        }
    }
}
