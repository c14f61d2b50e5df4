"""What is watched whatever the rover is about: the time, the camera, the place. Each can bring the rover to rest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from rover.capture.frame import Frame
from rover.mission.sight import BLIND_AFTER, Sight
from rover.outcome import Outcome, RunStatus

# A cycle that comes so much later than the one before, seconds: longer than any planning, or any hiccup of a computer.
GAP_S = 5.0


@dataclass
class Concerns:
    """What one check brought up. notes: for the timeline, each a reason to brake. end: why the mission cannot go on.

    home: it may still be driven back to the launch.
    """

    notes: list[str] = field(default_factory=list)
    end: Outcome | None = None
    home: bool = False


class Watch:
    """Times are seconds of the companion's clock."""

    def __init__(self, max_duration_s: float) -> None:
        self._max_duration = max_duration_s
        self._started: float | None = None
        self._sight = Sight()
        self._before: float | None = None
        # Seconds since the cycle before, when that is longer ago than GAP_S.
        self.gap: float | None = None
        # The camera shows nothing at the moment.
        self.blind = False
        # The rover has lost its place and has not begun to seek it yet.
        self.astray = False

    def take(self, now: float, frames: Sequence[Frame]) -> None:
        """One cycle's pictures; the first cycle begins the mission's time."""
        if self._started is None:
            self._started = now
        self.gap = None if self._before is None or now - self._before <= GAP_S else now - self._before
        self._before = now
        self._sight.take(now, frames)

    def lasted(self, now: float) -> float:
        """Seconds since the mission began."""
        return 0.0 if self._started is None else now - self._started

    def check(self, now: float, sigma: float, lost_place: bool, way_back_s: float = 0.0) -> Concerns:
        """`lost_place`: the pose, of 1σ `sigma` metres, must not be driven on, and nothing is done about it yet.

        `way_back_s`: seconds that the way back to the launch takes.
        """
        assert self._started is not None
        concerns = Concerns()
        if now - self._started > self._max_duration - way_back_s:
            why = f"the time limit of {self._max_duration:g} s ran out"
            if now - self._started <= self._max_duration:
                why += ", but for what the way back takes"
            concerns.end, concerns.home = Outcome(RunStatus.PARTIAL, why), True
        lost = self._sight.lost(now)
        if lost is not None:
            concerns.end, concerns.home = concerns.end or Outcome(RunStatus.PARTIAL, lost), False
        blind = self._sight.blind(now)
        if blind and not self.blind:
            concerns.notes.append(f"the camera has shown nothing for {BLIND_AFTER:g} s: the rover waits for pictures")
        self.blind = blind
        if lost_place and not self.astray:
            self.astray = True
            concerns.notes.append(f"the place is not known (1σ of {sigma:.2f} m): looking around")
        return concerns
