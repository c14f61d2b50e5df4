"""Asks the firmware on a port, serial or CAN, who and how it is, without moving anything."""

from __future__ import annotations

from dataclasses import dataclass

from rover.link.baud import DEFAULT_BAUD
from rover.link.clock import WallClock
from rover.link.firmware_document import in_words
from rover.link.handshake import Identity
from rover.link.inquiry import listen
from rover.link.opening import open_frames
from rover.link.session import Link
from rover.link.statistics import LinkFigures
from rover.link.telemetry import Battery, FirmwareState


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
