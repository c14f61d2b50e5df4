"""What firmware/pico/src/pins.rs wires, read from its text."""

from __future__ import annotations

import re

from rover_hil.firmware_process import ROOT

PINS_RS = ROOT / "firmware" / "pico" / "src" / "pins.rs"
SENSORS = ("left", "centre", "right")


def pins_source() -> str:
    """The file."""
    return PINS_RS.read_text(encoding="utf-8")


def wired_pins() -> dict[int, str]:
    """Pin number to signal from `Board::new`; the signal is the path of its field: `motors.left_in1`."""
    source = pins_source()
    path: list[str] = []
    pins: dict[int, str] = {}
    for line in source[source.index("pub fn new(p: Peripherals)") :].splitlines():
        if opened := re.match(r"\s*(\w+): \w+Pins \{$", line):
            path.append(opened.group(1))
        elif re.match(r"\s*\},$", line):
            path.pop()
        elif pin := re.match(r"\s*(\w+): .*\bp\.PIN_(\d+)", line):
            pins[int(pin.group(2))] = ".".join([*path, pin.group(1)])
    return pins


def pins_constant(name: str) -> int:
    """A whole number that the file defines. Raises KeyError."""
    constants = dict(re.findall(r"pub const (\w+): [ui]32 = ([\d_]+);", pins_source()))
    return int(constants[name].replace("_", ""))
