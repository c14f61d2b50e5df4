//! The control loop: 1 kHz, in an interrupt executor. Gathers the inputs, lets the core decide, sets the outputs.

use embassy_executor::task;
use embassy_time::{Duration, Instant, Timer};
use rover_core::{Core, Inputs, Reboot};

use crate::encoders::Encoders;
use crate::motors::Motors;
use crate::pins::PanelPins;
use crate::storage::ParameterFlash;
use crate::{battery, emergency, life, link, reset, sonar};

const PERIOD: Duration = Duration::from_millis(1);

/// What the loop owns.
pub struct Hardware {
    pub encoders: Encoders,
    pub motors: Motors,
    pub panel: PanelPins,
    pub flash: ParameterFlash,
}

#[task]
pub async fn run(core: &'static mut Core, mut hardware: Hardware) {
    let mut outgoing = [0; 64];
    // Ticks have nominal times, so that jitter of the start does not reach the motion; a late one is made up for.
    let mut now = Instant::now();
    loop {
        now += PERIOD;
        Timer::at(now).await;
        if link::take_overrun() {
            core.note_receive_overflow();
        }
        while let Ok(chunk) = link::RECEIVED.try_receive() {
            core.receive(chunk.bytes(), chunk.time_us);
        }
        let (encoder_left, encoder_right) = hardware.encoders.read();
        let outputs = core.tick(&Inputs {
            now_us: now.as_micros(),
            encoder_left,
            encoder_right,
            battery_mv: battery::millivolts(),
            emergency_stop: emergency::active(),
            sonar: sonar::ECHO.try_take(),
        });
        if outputs.powered {
            hardware.motors.drive(outputs.duty_left, outputs.duty_right);
        } else {
            hardware.motors.coast();
        }
        if core.wants_storage() {
            life::allow_flash_write();
            core.serve_storage(&mut hardware.flash);
        }
        if let Some(sensor) = outputs.sonar_trigger {
            sonar::TRIGGER.signal(sensor);
        }
        hardware.panel.led.set_level(outputs.led.into());
        hardware.panel.buzzer.set_level(outputs.buzzer.into());

        let room = link::OUTGOING.free_capacity().min(outgoing.len());
        if let Some(free) = outgoing.get_mut(..room) {
            let length = core.transmit(free);
            link::queue(free.get(..length).unwrap_or_default());
        }
        match core.take_reboot() {
            Some(Reboot::Restart) => reset::restart(),
            Some(Reboot::Bootloader) => reset::bootloader(),
            None => life::CONTROL.show(),
        }
    }
}
