"""Asks for a rover's state: its firmware over the port or, while a mission holds the port, the mission.

A mission answers from what it has heard anyway: nothing goes over the wire, so nobody who asks can disturb it.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from rover.cli.probe import ask
from rover.errors import BadInput, LinkLost
from rover.link.baud import DEFAULT_BAUD
from rover.link.claim import PortHeld
from rover.link.firmware_document import firmware_document
from rover.link.watching import Moment, from_dict, timed


def ask_politely(port: str, baud: int = DEFAULT_BAUD) -> dict[str, Any]:
    """The document of `rover status --json`; of a running mission with `mission` and `run` besides.

    Raises PreflightFailed (no port, no answer, held by somebody who does not answer), LinkLost (it went away).
    """
    try:
        answer = ask(port, baud)
    except PortHeld as held:
        if held.holder is None or not held.holder.run:
            raise
        told = _of_mission(Path(held.holder.run))
        if told is None:
            raise
        return {**told, "port": port, "run": held.holder.run}
    return firmware_document(port, answer.identity, answer.state, answer.battery, answer.figures)


def watch_mission(run: Path, period: float, seconds: float) -> Iterator[Moment]:
    """What the mission in a run's folder hears from its rover, a moment every `period` seconds until it has ended.

    Times are the mission's, from the first moment on. Raises LinkLost when it does not answer.
    """
    from rover.mission.ear import SOCKET
    from rover.mission.ear import ask as ask_mission

    begin = due = time.monotonic()
    first: float | None = None
    shown = Moment(0.0)
    while time.monotonic() - begin < seconds:
        try:
            told = ask_mission(run, {"op": "status"})
        except BadInput:
            if (run / SOCKET).exists():
                raise
            return  # it has ended
        moment = from_dict(told["measured"])
        first = moment.time_s if first is None else first
        shown = timed(moment, shown, moment.time_s - first, told.get("round_trip_ms"))
        yield shown
        due = max(due + period, time.monotonic())
        time.sleep(max(0.0, due - time.monotonic()))


def _of_mission(run: Path) -> dict[str, Any] | None:
    """None while a mission is still making its acquaintance, or does not answer."""
    from rover.mission.ear import ask as ask_mission

    try:
        told = ask_mission(run, {"op": "status"})
    except (BadInput, LinkLost):
        return None
    told.pop("ok", None)
    return told if "firmware" in told else None
