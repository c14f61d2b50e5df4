//! One tick on the pipes, in the core's terms.

use rover_core::{Inputs, Outputs, SonarEcho};
use rover_protocol::rig_tick::{TickReply, TickRequest, BUZZER, LED, NO_SENSOR, POWERED};

/// Steps of the board's PWM in one period.
const PWM_STEPS: i32 = 6_250;

/// The measurements that a request carries.
pub fn inputs(request: &TickRequest) -> Inputs {
    Inputs {
        now_us: request.now_us,
        began_us: request.now_us,
        encoder_left: request.encoder_left,
        encoder_right: request.encoder_right,
        battery_mv: request.battery_mv,
        emergency_stop: request.emergency_stop != 0,
        bumper: request.bumper != 0,
        sonar: (request.echo_sensor != NO_SENSOR).then_some(SonarEcho {
            sensor: request.echo_sensor,
            echo_us: request.echo_us,
        }),
        inertial: None,
    }
}

/// The reply; `bytes_sent` counts what went out on the serial line.
pub fn reply(outputs: &Outputs, bytes_sent: u64) -> TickReply {
    let flag = |on: bool, bit: u8| if on { bit } else { 0 };
    TickReply {
        duty_left: on_the_bridge(outputs.duty_left),
        duty_right: on_the_bridge(outputs.duty_right),
        flags: flag(outputs.powered, POWERED)
            | flag(outputs.led, LED)
            | flag(outputs.buzzer, BUZZER),
        sonar_trigger: outputs.sonar_trigger.unwrap_or(NO_SENSOR),
        bytes_sent,
    }
}

/// What the board's PWM makes of a duty in Q15: whole steps, cut off towards zero.
fn on_the_bridge(duty: i16) -> i16 {
    let steps = (i32::from(duty.unsigned_abs()) * PWM_STEPS) >> 15;
    let share = (steps * 32_768 + PWM_STEPS / 2) / PWM_STEPS;
    (share * i32::from(duty.signum())).clamp(-32_768, 32_767) as i16
}
