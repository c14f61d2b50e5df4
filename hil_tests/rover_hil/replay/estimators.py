"""Localization, map and detection on a stream that a person has imported: no firmware, no mission, poses come out."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from typing import Any

from rover.capture.frame import Frame
from rover.link.telemetry import SonarRange, WheelMotion
from rover.mission.perception import Perception
from rover.record.comparison import Comparison, Differs, RecordingOver
from rover.record.journal import Journal
from rover.record.log_reader import Log
from rover.record.topics import FIX, IMPORTED_SONAR, IMPORTED_WHEELS, PLACES

from rover_hil.client.frames import RigFrames
from rover_hil.replay.pace import Pace

# The rig's name in the log of an imported stream.
IMPORTED = "import"

Input = tuple[float, Frame | WheelMotion | SonarRange]
"""Time at which it is taken in, and what."""


class Estimators:
    """Takes inputs in the order of their times and writes down what comes of each frame."""

    def __init__(self, perception: Perception, journal: Journal) -> None:
        self._perception = perception
        self._journal = journal
        self._places: list[dict[str, Any]] = []

    def take(self, now: float, value: Frame | WheelMotion | SonarRange) -> None:
        """One input."""
        perception, journal = self._perception, self._journal
        if not isinstance(value, Frame):
            perception.take(value)
            return
        perception.see(value, now)
        journal.pose(now, perception.pose)
        if perception.last_fix is not None:
            journal.event(FIX, now, perception.last_fix)
        places = [
            {"id": p.id, "class": p.kind, "p": p.mine_probability, "x": p.x, "y": p.y, "sigma_m": p.sigma_m}
            for p in perception.suspected
        ]
        if places != self._places:
            self._places = places
            journal.event(PLACES, now, {"places": places})


def write_input(journal: Journal, now: float, value: Frame | WheelMotion | SonarRange) -> None:
    """Into the log, so that `read_inputs` gives it back."""
    if isinstance(value, Frame):
        journal.frame(now, value)
    else:
        journal.event(IMPORTED_WHEELS if isinstance(value, WheelMotion) else IMPORTED_SONAR, now, value)


def read_inputs(log: Log) -> Iterator[Input]:
    """What `write_input` has written, in that order."""
    pictures = log.frames()
    picture = next(pictures, None)
    frames = RigFrames()
    for message in log.messages((IMPORTED_WHEELS, IMPORTED_SONAR)):
        while picture is not None and picture.time_ns < message.time_ns:
            frames.accept([picture.header], picture.pixels)
            yield picture.time_ns * 1e-9, next(iter(frames))
            picture = next(pictures, None)
        kind = WheelMotion if message.topic == IMPORTED_WHEELS else SonarRange
        yield message.time_ns * 1e-9, kind(**json.loads(message.data))
    while picture is not None:
        frames.accept([picture.header], picture.pixels)
        yield picture.time_ns * 1e-9, next(iter(frames))
        picture = next(pictures, None)


def replay_estimators(
    log: Log, perception: Perception, comparison: Comparison, pace: Pace, on_time: Callable[[float], None]
) -> int:
    """Feeds an imported log; the comparison holds what came of it. Returns the number of frames."""
    estimators = Estimators(perception, comparison)
    frames = 0
    try:
        for now, value in read_inputs(log):
            pace.wait(now)
            on_time(now)
            frames += isinstance(value, Frame)
            estimators.take(now, value)
        comparison.finish()
    except (Differs, RecordingOver):
        pass  # what differs is kept in the comparison
    return frames
