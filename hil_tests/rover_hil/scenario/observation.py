"""What a scenario can look at: names, what kind of value each has, and one moment of a run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from rover_protocol import messages

NUMBERS = {
    "time_s": "simulated seconds since the rover was switched on",
    "speed": "true ground speed, m/s, never negative",
    "turn_rate": "true turn rate, rad/s, never negative",
    "commanded_speed": "what the firmware is at in the motion that it was sent, m/s, negative backwards",
    "commanded_turn_rate": "the same about the vertical, rad/s, positive to the left",
    "travelled_m": "true way of base_link since the start",
    "turned_deg": "true turn since the start, both ways added up",
    "advance_m": "true way since the start along the launch heading",
    "heading_deg": "true heading relative to the launch",
    "battery_v": "true voltage at the battery",
    "clearance_m": "smallest true distance from the footprint to an obstacle so far",
    "collisions": "contacts harder than 0.1 m/s that the referee has counted",
    "bumper_contacts": "the softer ones",
    "duty": "larger of both duties that the motors really get, 0 to 1",
    "cause_detail": "State.cause_detail of the firmware",
    "queued": "segments in the firmware's queue",
    "next_index": "index of the segment that the firmware expects next",
    "rejected": "segments that the firmware has refused",
    "lost": "gaps in the sequence of what the firmware has received",
    "checksum_errors": "frames with wrong checksum that the firmware has received",
    "malformed": "frames that the firmware has not understood",
    "sonar_m": "range of the centre sonar as the firmware tells it; 65.535 without an echo",
    "boots": "starts of the firmware so far",
    "unseen_m2": "ground driven on that no frame had shown, m²",
    "mine_m": "true distance from base_link to the edge of the nearest mine; 99 without mines",
    "mines_driven_over": "mines that a wheel was on, counted at the end of a mission",
    "keepout_violations": "entries of wheels into keep-out zones, counted at the end; -1 when the companion was killed",
    "mines_with_contrast_found": "mines of at least 0.5 K that were reported, counted in the same way",
    "false_indications": "indications where no mine is, counted in the same way",
}
FLAGS = {
    "powered": "the motors really are powered",
    "handshake": "the firmware has accepted the companion's handshake",
    "emergency_input": "the firmware sees the emergency-stop input",
    "bumper": "the firmware sees a pressed switch of the bumper",
    "driving": "the scripted drive is not at its end",
    "buzzer": "the buzzer sounds",
}
COMPANION_WORDS = (
    "Starting", "Driving", "Done", "Partial", "NoPath", "Aborted", "PreflightFailed", "SafetyStop", "LinkLost",
    "Killed", "Failed",
)  # fmt: skip
WORDS: dict[str, tuple[str, ...]] = {
    "state": tuple(messages.VALUES["State"]["state"].values()),
    "cause": tuple(messages.VALUES["State"]["cause"].values()),
    "reset_cause": tuple(messages.VALUES["HelloBuild"]["reset_cause"].values()),
    "parameter_status": ("None", *messages.VALUES["ParameterValue"]["status"].values()),
    "companion": COMPANION_WORDS,
}

Values = Mapping[str, "float | str | bool"]


def known_counter(fault: str) -> bool:
    """Whether the protocol has a fault of that name."""
    return fault in messages.VALUES["Fault"]["code"].values()


@dataclass(frozen=True)
class Moment:
    """Everything observed at one time."""

    time: float
    values: Values


@dataclass
class Track:
    """All moments of a run, and what happened in it."""

    moments: list[Moment] = field(default_factory=list)
    events: list[tuple[float, str]] = field(default_factory=list)

    @property
    def last(self) -> Moment:
        """The newest moment."""
        return self.moments[-1]
