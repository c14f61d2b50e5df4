"""Asks the firmware on a port, serial or CAN, who and how it is, without moving anything."""

from __future__ import annotations

from dataclasses import dataclass

from rover.link.baud import DEFAULT_BAUD
from rover.link.clock import WallClock
from rover.link.handshake import Identity
from rover.link.inquiry import listen
from rover.link.opening import open_frames
from rover.link.session import Link
from rover.link.statistics import LinkFigures
from rover.link.telemetry import Battery, FirmwareState

CAUSES = {
    "None": "nothing has stopped it since it started",
    "StopCommand": "it was told to stop",
    "EmergencyCommand": "it was told to stop at once",
    "EmergencyInput": "the emergency-stop button was pressed",
    "DeadMan": "the dead-man stopped it, nothing was heard from the companion",
    "SonarGuard": "the sonar guard stopped it, something was too close ahead",
    "LowBattery": "the battery was too low",
    "Stall": "a wheel did not turn although it was driven",
    "EncoderFault": "a wheel encoder told nonsense",
    "Underrun": "the motion queue ran empty while it moved",
    "Disarm": "it was disarmed",
    "Internal": "the firmware met an error of its own",
    "Bumper": "its bumper touched something",
    "SensorLost": "a sonar no longer answered while it drove forward",
    "InjectorSilent": "in test mode, what plays its sensors fell silent",
}


@dataclass(frozen=True)
class Answer:
    """What a firmware said."""

    identity: Identity
    state: FirmwareState
    battery: Battery | None
    figures: LinkFigures
    sonars: dict[int, str]
    """Last status of each sensor that has told one, by its number."""

    @property
    def meaning(self) -> str:
        """State and cause in words."""
        return in_words(self.state)


def in_words(state: FirmwareState) -> str:
    """State and cause of the last stop, as one phrase an operator understands."""
    cause = CAUSES.get(state.cause, f"cause {state.cause}, which this version does not know")
    name = state.state.lower()
    if state.state in ("Latched", "Stopping"):
        return f"{name}: {cause}"
    return name if state.cause == "None" else f"{name}; last stop: {cause}"


def ask(port: str, baud: int = DEFAULT_BAUD) -> Answer:
    """Handshake, then a short listen. Raises PreflightFailed (no port, no answer), LinkLost (it went away)."""
    clock = WallClock()
    link = Link(open_frames(port, baud, clock), clock)
    try:
        identity = link.connect()
        told = listen(link)
        return Answer(identity, told.state, told.battery, link.figures(), told.sonars)
    finally:
        link.close()
