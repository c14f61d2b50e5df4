"""Lets a link live for a while, as the loop of a mission does."""

from __future__ import annotations

from rover.link.session import STEP_S, Link
from rover.link.telemetry import Telemetry


def listen(link: Link, seconds: float) -> list[Telemetry]:
    """Polls every 20 ms; returns all that came."""
    events: list[Telemetry] = []
    end = link.clock.now() + seconds
    while link.clock.now() < end:
        events.extend(link.poll())
        link.clock.advance(link.clock.now() + STEP_S)
    return events
