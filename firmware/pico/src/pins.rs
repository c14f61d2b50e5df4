//! What is wired to which pin of a Raspberry Pi Pico. docs/guide/hardware.md mirrors this file.
//!
//! GP27 is free: it is an input of the analogue-digital converter.

use embassy_rp::gpio::{Flex, Input, Level, Output, Pull};
use embassy_rp::peripherals::{
    ADC, FLASH, I2C0, PIN_0, PIN_1, PIN_16, PIN_18, PIN_19, PIN_2, PIN_20, PIN_21, PIN_26, PIN_3,
    PIN_4, PIN_5, PIN_6, PIN_7, PIN_8, PIN_9, PIO0, PWM_SLICE3, PWM_SLICE4, SPI0, UART0, USB,
    WATCHDOG,
};
use embassy_rp::{Peri, Peripherals};
use rover_mcp2515::{Bitrate, Crystal};

/// Baud rate of the serial link.
pub const BAUD: u32 = 230_400;

/// Crystal on the board of the MCP2515.
pub const CAN_CRYSTAL: Crystal = Crystal::Mhz8;
/// Bit rate of the CAN bus.
pub const CAN_BITRATE: Bitrate = Bitrate::Kbit500;

/// STBY of the TB6612 (nSLEEP of the DRV8833), as a bit of the GPIO registers, for what must work without owning the pin.
pub const STANDBY_MASK: u32 = 1 << 12;
/// As for STBY.
pub const EMERGENCY_STOP_MASK: u32 = 1 << 28;

/// Battery voltage over the voltage at the pin: 20 kOhm above 10 kOhm.
pub const BATTERY_DIVIDER: u32 = 3;
/// Reference of the analogue-digital converter, in mV.
pub const ADC_REFERENCE_MV: u32 = 3_300;

/// +1 when channel A leads B while the wheel drives the rover forwards, else -1. The motors face each other.
pub const LEFT_ENCODER_SIGN: i32 = 1;
/// As for the left one.
pub const RIGHT_ENCODER_SIGN: i32 = 1;

/// Serial link to the companion.
pub struct LinkPins {
    pub uart: Peri<'static, UART0>,
    /// To the companion's RX.
    pub tx: Peri<'static, PIN_0>,
    /// From the companion's TX.
    pub rx: Peri<'static, PIN_1>,
}

/// MCP2515 on SPI.
pub struct CanPins {
    pub spi: Peri<'static, SPI0>,
    pub miso: Peri<'static, PIN_16>,
    pub clock: Peri<'static, PIN_18>,
    pub mosi: Peri<'static, PIN_19>,
    /// CS, GP17.
    pub select: Output<'static>,
    /// INT, GP10: low while something is to be done. Pulled up, so that it rests when no chip is there.
    pub interrupt: Input<'static>,
}

/// Quadrature encoders, pulled up. A and B of each are neighbours, as the PIO reads both at once.
pub struct EncoderPins {
    pub pio: Peri<'static, PIO0>,
    pub left_a: Peri<'static, PIN_2>,
    pub left_b: Peri<'static, PIN_3>,
    pub right_a: Peri<'static, PIN_4>,
    pub right_b: Peri<'static, PIN_5>,
}

/// H-bridge with two inputs a motor: DRV8833, or TB6612FNG with PWMA and PWMB tied to 3.3 V. The inputs of one motor
/// are the two channels of one PWM slice, so that both change in the same PWM period.
pub struct MotorPins {
    pub left_slice: Peri<'static, PWM_SLICE3>,
    pub left_in1: Peri<'static, PIN_6>,
    pub left_in2: Peri<'static, PIN_7>,
    pub right_slice: Peri<'static, PWM_SLICE4>,
    pub right_in1: Peri<'static, PIN_8>,
    pub right_in2: Peri<'static, PIN_9>,
    /// STBY or nSLEEP, GP12: low takes both bridges off.
    pub standby: Output<'static>,
}

/// Three HC-SR04, one pin each: it triggers, then listens to the echo, which comes through a divider.
pub struct SonarPins {
    /// GP13.
    pub left: Flex<'static>,
    /// GP14.
    pub centre: Flex<'static>,
    /// GP15.
    pub right: Flex<'static>,
}

/// LSM6DSO on I2C.
pub struct InertialPins {
    pub i2c: Peri<'static, I2C0>,
    pub data: Peri<'static, PIN_20>,
    pub clock: Peri<'static, PIN_21>,
}

/// Battery voltage through [`BATTERY_DIVIDER`].
pub struct BatteryPins {
    pub adc: Peri<'static, ADC>,
    pub voltage: Peri<'static, PIN_26>,
}

/// What the operator sees and hears.
pub struct PanelPins {
    /// On the board, GP25.
    pub led: Output<'static>,
    /// Active buzzer through a transistor, GP22.
    pub buzzer: Output<'static>,
}

/// Everything that is wired.
pub struct Board {
    pub link: LinkPins,
    pub can: CanPins,
    /// The socket of the board.
    pub usb: Peri<'static, USB>,
    pub encoders: EncoderPins,
    pub motors: MotorPins,
    pub sonars: SonarPins,
    pub inertial: InertialPins,
    pub battery: BatteryPins,
    pub panel: PanelPins,
    /// Normally closed switch to ground, GP28: a broken wire stops the rover.
    pub emergency_stop: Input<'static>,
    /// Two normally closed switches in series to ground, GP11: pressing either, or a broken wire, reads high. Without a
    /// bumper the pin is wired to ground.
    pub bumper: Input<'static>,
    pub watchdog: Peri<'static, WATCHDOG>,
    /// On the board, for parameters.
    pub flash: Peri<'static, FLASH>,
}

impl Board {
    /// Hand out the peripherals; outputs start so that motors, buzzer and CAN controller rest.
    pub fn new(p: Peripherals) -> Self {
        Self {
            link: LinkPins {
                uart: p.UART0,
                tx: p.PIN_0,
                rx: p.PIN_1,
            },
            can: CanPins {
                spi: p.SPI0,
                miso: p.PIN_16,
                clock: p.PIN_18,
                mosi: p.PIN_19,
                select: Output::new(p.PIN_17, Level::High),
                interrupt: Input::new(p.PIN_10, Pull::Up),
            },
            usb: p.USB,
            encoders: EncoderPins {
                pio: p.PIO0,
                left_a: p.PIN_2,
                left_b: p.PIN_3,
                right_a: p.PIN_4,
                right_b: p.PIN_5,
            },
            motors: MotorPins {
                left_slice: p.PWM_SLICE3,
                left_in1: p.PIN_6,
                left_in2: p.PIN_7,
                right_slice: p.PWM_SLICE4,
                right_in1: p.PIN_8,
                right_in2: p.PIN_9,
                standby: Output::new(p.PIN_12, Level::Low),
            },
            sonars: SonarPins {
                left: Flex::new(p.PIN_13),
                centre: Flex::new(p.PIN_14),
                right: Flex::new(p.PIN_15),
            },
            inertial: InertialPins {
                i2c: p.I2C0,
                data: p.PIN_20,
                clock: p.PIN_21,
            },
            battery: BatteryPins {
                adc: p.ADC,
                voltage: p.PIN_26,
            },
            panel: PanelPins {
                led: Output::new(p.PIN_25, Level::Low),
                buzzer: Output::new(p.PIN_22, Level::Low),
            },
            emergency_stop: Input::new(p.PIN_28, Pull::Up),
            bumper: Input::new(p.PIN_11, Pull::Up),
            watchdog: p.WATCHDOG,
            flash: p.FLASH,
        }
    }
}
