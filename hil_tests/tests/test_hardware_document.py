"""docs/guide/hardware.md wires what the firmware's pins.rs says, pin by pin."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from rover_hil.testing.pins import pins_constant, pins_source, wired_pins

REPOSITORY = Path(__file__).resolve().parents[2]


def documented() -> dict[int, str]:
    """Pin number to signal from the wiring table."""
    text = (REPOSITORY / "docs/guide/hardware.md").read_text(encoding="utf-8")
    return {int(pin): signal for pin, signal in re.findall(r"^\| GP(\d+) \| (\S+) \|", text, re.MULTILINE)}


def test_the_wiring_table_is_pins_rs() -> None:
    pins = wired_pins()
    assert len(pins) == 26, "pins.rs is read as it is written"
    assert documented() == pins


def test_the_dividers_are_those_that_the_firmware_counts_with() -> None:
    text = (REPOSITORY / "docs/guide/hardware.md").read_text(encoding="utf-8")
    found = re.search(r"(\d+) kΩ from the battery's plus to GP26, (\d+) kΩ", text)
    assert found
    above, below = (int(value) for value in found.groups())
    assert (above + below) / below == pytest.approx(pins_constant("BATTERY_DIVIDER"))


def test_masks_and_free_pins_fit_the_table() -> None:
    pins = wired_pins()
    masks = dict(re.findall(r"(\w+)_MASK: u32 = 1 << (\d+);", pins_source()))
    assert pins[int(masks["STANDBY"])] == "motors.standby"
    assert pins[int(masks["EMERGENCY_STOP"])] == "emergency_stop"
    assert pins[11] == "bumper"
