//! One millisecond on the pipes: a request of 40 bytes, a reply of 16, little-endian and packed.

use rover_core::{Inputs, Outputs, SonarEcho};

pub const REQUEST: usize = 40;
pub const REPLY: usize = 16;
const NO_SENSOR: u8 = 255;
/// Steps of the board's PWM in one period.
const PWM_STEPS: i32 = 6_250;

/// A decoded request.
#[derive(Clone, Copy, Debug)]
pub struct Request {
    pub inputs: Inputs,
    /// Bytes that must have come over the serial line before this tick, in total; `u64::MAX` takes what is there.
    pub host_bytes_due: u64,
}

impl Request {
    pub fn decode(bytes: &[u8; REQUEST]) -> Self {
        let sensor = bytes[22];
        let echo_us = u32::from_le_bytes(part(bytes, 16));
        Self {
            inputs: Inputs {
                now_us: u64::from_le_bytes(part(bytes, 0)),
                encoder_left: i32::from_le_bytes(part(bytes, 8)),
                encoder_right: i32::from_le_bytes(part(bytes, 12)),
                battery_mv: u16::from_le_bytes(part(bytes, 20)),
                emergency_stop: bytes[23] != 0,
                sonar: (sensor != NO_SENSOR).then_some(SonarEcho { sensor, echo_us }),
            },
            host_bytes_due: u64::from_le_bytes(part(bytes, 24)),
        }
    }
}

/// What the board's PWM makes of a duty in Q15: whole steps, cut off towards zero.
fn on_the_bridge(duty: i16) -> i16 {
    let steps = (i32::from(duty.unsigned_abs()) * PWM_STEPS) >> 15;
    let share = (steps * 32_768 + PWM_STEPS / 2) / PWM_STEPS;
    (share * i32::from(duty.signum())).clamp(-32_768, 32_767) as i16
}

/// Encode the reply; `bytes_sent` counts what went out on the serial line.
pub fn encode_reply(outputs: &Outputs, bytes_sent: u64) -> [u8; REPLY] {
    let mut reply = [0; REPLY];
    reply[0..2].copy_from_slice(&on_the_bridge(outputs.duty_left).to_le_bytes());
    reply[2..4].copy_from_slice(&on_the_bridge(outputs.duty_right).to_le_bytes());
    reply[4] =
        u8::from(outputs.powered) | u8::from(outputs.led) << 1 | u8::from(outputs.buzzer) << 2;
    reply[5] = outputs.sonar_trigger.unwrap_or(NO_SENSOR);
    reply[8..16].copy_from_slice(&bytes_sent.to_le_bytes());
    reply
}

fn part<const N: usize>(bytes: &[u8; REQUEST], at: usize) -> [u8; N] {
    let mut out = [0; N];
    out.copy_from_slice(&bytes[at..at + N]);
    out
}
