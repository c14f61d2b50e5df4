//! The control loop: 1 kHz, in an interrupt executor. Gathers the inputs, lets the core decide, sets the outputs.

use embassy_rp::gpio::Input;
use embassy_time::{Duration, Instant};
use rover_core::{Core, Inputs, Reboot};

use crate::battery::Battery;
use crate::crash::{self, task};
use crate::encoders::Encoders;
use crate::link::Link;
use crate::motors::Motors;
use crate::pins::PanelPins;
use crate::storage::ParameterFlash;
use crate::tick::Ticker;
use crate::{emergency, inertial, life, reset, sonar};

const PERIOD: Duration = Duration::from_millis(1);

/// What the loop owns.
pub struct Hardware {
    pub link: Link,
    pub battery: Battery,
    pub encoders: Encoders,
    pub motors: Motors,
    pub panel: PanelPins,
    /// High while a switch is pressed.
    pub bumper: Input<'static>,
    pub flash: ParameterFlash,
}

#[embassy_executor::task]
pub async fn run(core: &'static mut Core, hardware: Hardware) {
    crash::within(task::CONTROL, control(core, hardware)).await
}

async fn control(core: &'static mut Core, mut hardware: Hardware) -> ! {
    let mut ticker = Ticker::every(PERIOD);
    let mut powered = false;
    loop {
        let now = ticker.next().await;
        let began = Instant::now();
        hardware.link.receive(core, powered);
        let (encoder_left, encoder_right) = hardware.encoders.read();
        let outputs = core.tick(&Inputs {
            now_us: now.as_micros(),
            began_us: began.as_micros(),
            encoder_left,
            encoder_right,
            battery_mv: hardware.battery.measure(now),
            emergency_stop: emergency::active(),
            bumper: hardware.bumper.is_high(),
            sonar: sonar::ECHO.try_take(),
            inertial: inertial::take(now),
        });
        powered = outputs.powered;
        while let Some(event) = core.take_event() {
            crash::note(&event);
        }
        if powered {
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

        hardware.link.transmit(core);
        if hardware.link.is_alive() {
            life::LINK.show();
        }
        match core.take_reboot() {
            Some(Reboot::Restart) => reset::restart(),
            Some(Reboot::Bootloader) => reset::bootloader(),
            None => life::CONTROL.show(),
        }
    }
}
