"""What is watched whatever the rover is about: the time, the camera, the place. Each can bring the rover to rest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from rover.capture.frame import Frame
from rover.mission.sight import BLIND_AFTER, Sight
from rover.outcome import Outcome, RunStatus


@dataclass
class Concerns:
    """What one check brought up. notes: for the timeline, each a reason to brake. end: why the mission cannot go on."""

    notes: list[str] = field(default_factory=list)
    end: Outcome | None = None


class Watch:
    """Times are seconds of the companion's clock."""

    def __init__(self, max_duration_s: float) -> None:
        self._max_duration = max_duration_s
        self._started: float | None = None
        self._sight = Sight()
        # The camera shows nothing at the moment.
        self.blind = False
        # The rover has lost its place and has not begun to seek it yet.
        self.astray = False

    def take(self, now: float, frames: Sequence[Frame]) -> None:
        """One cycle's pictures; the first cycle begins the mission's time."""
        if self._started is None:
            self._started = now
        self._sight.take(now, frames)

    def check(self, now: float, sigma: float, lost_place: bool) -> Concerns:
        """`lost_place`: the pose, of 1σ `sigma` metres, must not be driven on, and nothing is done about it yet."""
        assert self._started is not None
        concerns = Concerns()
        if now - self._started > self._max_duration:
            concerns.end = Outcome(RunStatus.PARTIAL, f"the time limit of {self._max_duration:g} s ran out")
        lost = self._sight.lost(now)
        if lost is not None:
            concerns.end = concerns.end or Outcome(RunStatus.PARTIAL, lost)
        blind = self._sight.blind(now)
        if blind and not self.blind:
            concerns.notes.append(f"the camera has shown nothing for {BLIND_AFTER:g} s: the rover waits for pictures")
        self.blind = blind
        if lost_place and not self.astray:
            self.astray = True
            concerns.notes.append(f"the place is not known (1σ of {sigma:.2f} m): looking around")
        return concerns
