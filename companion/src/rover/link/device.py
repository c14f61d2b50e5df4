"""The companion's end of a real rover: wall clock, a port, a camera that a thread reads.

Offers what a lock-stepped rig offers, so the loop of a mission is the same. Cycles lie on a grid; one that begins late
because the work before it took too long is counted.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from rover.capture.frame import KELVIN_PER_COUNT, Frame
from rover.capture.latest import LatestFrames
from rover.capture.plausible import doubt, jump
from rover.errors import BadInput
from rover.link.clock import WallClock
from rover.link.frames import FrameTransport
from rover.link.intake import Cycle, OnCycle, TappedWire

# Seconds by which a cycle may begin late without being counted: what a sleep of the system is off by.
MAX_LATE_S = 0.001

COUNTS = 1 << 16


@dataclass(frozen=True)
class Pace:
    """How well the loop has kept its time. Longest: seconds from one cycle to the next."""

    cycles: int
    overruns: int
    longest: float
    frames_dropped: int


class DeviceRig:
    """A real rover in real time. Is the `Clock` of its mission: its time stands still within a cycle.

    camera_failure: why no more pictures come, once the camera has been given up.
    """

    def __init__(
        self, wire: FrameTransport, camera: LatestFrames, clock: WallClock, on_cycle: OnCycle | None = None
    ) -> None:
        """`wire` and the times of `camera`'s pictures (system's monotonic clock) go by `clock`."""
        self.cycle = Cycle(_whole(clock.now()))
        self.transport = TappedWire(wire, self)
        self.camera_failure: str | None = None
        self._camera = camera
        self._shown: Frame | None = None
        self._clock = clock
        self._on_cycle = on_cycle
        self._dropped_before = camera.dropped
        self._cycles = self._overruns = 0
        self._longest = 0.0
        camera.take()  # pictures of before the mission

    def now(self) -> float:
        """Time of the cycle, seconds."""
        return self.cycle.time

    def lead(self) -> float:
        """Seconds since the cycle's own time."""
        return self._clock.now() - self.cycle.time

    def next_cycle(self, period: float) -> float:
        """When the next cycle begins: a period after the last, or now when that has gone by."""
        due, real = _whole(self.cycle.time + period), _whole(self._clock.now())
        self._cycles += 1
        self._longest = max(self._longest, real - self.cycle.time, period)
        if real <= due + MAX_LATE_S:
            return due
        self._overruns += 1
        return real

    def advance(self, to: float) -> None:
        """Waits until `to` and begins a cycle of that time."""
        self._hand_over()
        self._clock.advance(to)
        self.cycle = Cycle(to)

    @property
    def frames(self) -> list[Frame]:
        """Pictures that have come, in kelvin × 100, by the companion's clock in whole µs."""
        if self.camera_failure is not None:
            return []
        try:
            return [self._by_our_clock(self._checked(in_centikelvin(frame))) for frame in self._camera.take()]
        except Exception as error:  # whatever a driver throws: the mission ends in order, for want of pictures
            self.camera_failure = str(error) or type(error).__name__
            return []

    @property
    def pace(self) -> Pace:
        """Since the mission began."""
        dropped = self._camera.dropped - self._dropped_before
        return Pace(self._cycles, self._overruns, self._longest, dropped)

    def finish(
        self, zones: Sequence[dict[str, Any]] = (), detections: Sequence[dict[str, Any]] = ()
    ) -> dict[str, Any] | None:
        """Nobody knows the truth of a real field."""
        self._hand_over()
        return None

    def _checked(self, frame: Frame) -> Frame:
        """A picture that cannot be ground counts as one behind the shutter: nobody uses it, and the rover waits."""
        if frame.ffc:
            return frame
        found = frame.doubt or doubt(frame.counts, frame.kelvin_per_count)
        if found is None and self._shown is not None:
            found = jump(self._shown, frame)
        self._shown = frame
        return frame if found is None else replace(frame, ffc=True, doubt=found)

    def _by_our_clock(self, frame: Frame) -> Frame:
        return replace(frame, time=_whole(frame.time - self._clock.origin))

    def _hand_over(self) -> None:
        if self._on_cycle is not None:
            self._on_cycle(self.cycle)


def in_centikelvin(frame: Frame) -> Frame:
    """The same picture in kelvin × 100, as missions and logs hold them. Raises BadInput for raw counts."""
    if frame.kelvin_per_count == KELVIN_PER_COUNT:
        return frame
    if frame.kelvin_per_count is None:
        raise BadInput(f"{frame.camera or 'the camera'}: {frame.doubt or 'raw counts are no temperatures'}")
    counts = np.round(frame.counts * (frame.kelvin_per_count / KELVIN_PER_COUNT))
    if counts.max(initial=0.0) >= COUNTS:
        raise BadInput(f"{frame.camera or 'the camera'}: a picture of more than {COUNTS * KELVIN_PER_COUNT:.0f} K")
    return replace(frame, counts=counts.astype(np.uint16), kelvin_per_count=KELVIN_PER_COUNT)


def _whole(seconds: float) -> float:
    """In whole microseconds, as a log holds times."""
    return round(seconds * 1e6) * 1e-6
