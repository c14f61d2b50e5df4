"""What a firmware that has just come up says of itself, judged: may the rover be used?"""

from __future__ import annotations

from dataclasses import dataclass

from rover.link.telemetry import Battery, FirmwareState

SENSORS = ("left", "centre", "right")


@dataclass(frozen=True)
class Finding:
    """One line of the self-test."""

    name: str
    ok: bool
    detail: str


def self_test(state: FirmwareState, battery: Battery | None, sonars: dict[int, str]) -> list[Finding]:
    """Findings in a fixed order. `sonars`: last status of each sensor that has told one."""
    faults = ", ".join(state.faults)
    low = "LowBattery" in state.faults
    volts = "not told" if battery is None else f"{battery.voltage:.2f} V" + (" is too low" if low else "")
    return [
        Finding("state", state.state in ("Disarmed", "Boot"), f"{state.state}, last stop: {state.cause}"),
        Finding("faults", not faults, faults or "none"),
        Finding("battery", battery is not None and not low, volts),
        Finding("emergency stop", not state.emergency_input, "pressed" if state.emergency_input else "released"),
        Finding("bumper", not state.bumper, "pressed, or a wire is off" if state.bumper else "free"),
        *(_sonar(name, sonars.get(number)) for number, name in enumerate(SENSORS)),
    ]


def _sonar(name: str, status: str | None) -> Finding:
    alive = {"Ok": "measures", "NoEcho": "measures, nothing in range"}
    detail = alive.get(status or "", "says nothing" if status is None else "does not answer: is it connected?")
    return Finding(f"sonar {name}", status in alive, detail)
