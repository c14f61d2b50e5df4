"""docs/guide/hardware.md wires what the firmware's pins.rs says, pin by pin."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[2]
SENSORS = ("left", "centre", "right")


def wired() -> dict[int, str]:
    """Pin number to signal from `Board::new` of pins.rs; the signal is the path of its field."""
    source = (REPOSITORY / "firmware/pico/src/pins.rs").read_text(encoding="utf-8")
    body = source[source.index("pub fn new(p: Peripherals)") :]
    path: list[str] = []
    sensor = -1
    pins: dict[int, str] = {}
    for line in body.splitlines():
        opened = re.match(r"\s*(?:(\w+): )?(\w+Pins \{|\[)$", line)
        if opened:
            if opened.group(1) is None:
                sensor += 1
            path.append(opened.group(1) or SENSORS[sensor])
        elif re.match(r"\s*[}\]],$", line):
            path.pop()
        elif pin := re.match(r"\s*(\w+): .*\bp\.PIN_(\d+)", line):
            pins[int(pin.group(2))] = ".".join([*path, pin.group(1)])
    return pins


def documented() -> dict[int, str]:
    """Pin number to signal from the wiring table."""
    text = (REPOSITORY / "docs/guide/hardware.md").read_text(encoding="utf-8")
    return {int(pin): signal for pin, signal in re.findall(r"^\| GP(\d+) \| (\S+) \|", text, re.MULTILINE)}


def test_the_wiring_table_is_pins_rs() -> None:
    pins = wired()
    assert len(pins) == 26, "pins.rs is read as it is written"
    assert documented() == pins


def test_the_dividers_are_those_that_the_firmware_counts_with() -> None:
    source = (REPOSITORY / "firmware/pico/src/pins.rs").read_text(encoding="utf-8")
    text = (REPOSITORY / "docs/guide/hardware.md").read_text(encoding="utf-8")
    divider = re.search(r"BATTERY_DIVIDER: u32 = (\d+);", source)
    above, below = re.search(r"(\d+) kΩ from the battery's plus to GP26, (\d+) kΩ", text).groups()
    assert (int(above) + int(below)) / int(below) == pytest.approx(int(divider.group(1)))


def test_masks_and_free_pins_fit_the_table() -> None:
    source = (REPOSITORY / "firmware/pico/src/pins.rs").read_text(encoding="utf-8")
    pins = wired()
    masks = dict(re.findall(r"(\w+)_MASK: u32 = 1 << (\d+);", source))
    assert pins[int(masks["STANDBY"])] == "motors.standby"
    assert pins[int(masks["EMERGENCY_STOP"])] == "emergency_stop"
    assert 11 not in pins
