"""Listens to a firmware that has shaken hands: what it tells by itself within a moment, without moving anything."""

from __future__ import annotations

from dataclasses import dataclass

from rover.link.session import STEP_S, Link
from rover.link.telemetry import Battery, FirmwareState, SonarRange

# Seconds to listen after the handshake: the battery is told twice a second.
LISTEN_S = 0.7


@dataclass(frozen=True)
class Told:
    """State, battery if it was told, and the last status of each sonar by its number."""

    state: FirmwareState
    battery: Battery | None
    sonars: dict[int, str]


def listen(link: Link) -> Told:
    """Of a link that is connected. Raises LinkLost."""
    battery: Battery | None = None
    sonars: dict[int, str] = {}
    clock = link.clock
    end = clock.now() + LISTEN_S
    while clock.now() < end:
        for event in link.poll():
            if isinstance(event, Battery):
                battery = event
            elif isinstance(event, SonarRange):
                sonars[event.sensor] = event.status
        clock.advance(clock.now() + STEP_S)
    assert link.state is not None  # connect waits for it
    return Told(link.state, battery, sonars)
