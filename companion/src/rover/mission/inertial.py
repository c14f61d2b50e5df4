"""What the inertial sensor tells the estimators: turns between wheel reports, and which way was up at a picture.

Everything is None without one, and where it was silent: then wheels and camera do as if there were none.
"""

from __future__ import annotations

from collections import deque

from rover.link.telemetry import Gravity, Telemetry, Turned

# A report older than this, seconds, says nothing of now; the rover turns by less than a tenth of a radian meanwhile.
STALE_S = 0.03
# Of the vertical, which changes slowly.
OLD_S = 0.1
# As many as cover the time that a picture is on its way.
KEPT = 64
SETTLING, LOST = "Settling", "Lost"


class Inertial:
    """The newest of its telemetry, and the vertical of the last second."""

    def __init__(self) -> None:
        self._turned: Turned | None = None
        self._before: float | None = None
        self._up: deque[Gravity] = deque(maxlen=KEPT)

    def take(self, event: Telemetry) -> None:
        """One piece of telemetry, of whatever kind."""
        if isinstance(event, Turned):
            self._turned = event
        elif isinstance(event, Gravity):
            if event.status == LOST:
                self._up.clear()
            else:
                self._up.append(event)

    @property
    def settling(self) -> bool:
        """There is a sensor, and the bias of its gyroscope is not known yet: that takes a second of rest."""
        return bool(self._up) and self._up[-1].status == SETTLING

    def turn(self, time: float) -> float | None:
        """What the rover has turned by since the last call, radians, counter-clockwise."""
        last = self._turned
        if last is None or abs(time - last.time) > STALE_S:
            self._before = None
            return None
        heading = last.heading + last.rate * (time - last.time)
        before, self._before = self._before, heading
        return None if before is None else heading - before

    def up(self, time: float) -> tuple[float, float, float] | None:
        """The vertical on base_link at a time of the last second, m/s²."""
        near = min(self._up, key=lambda event: abs(event.time - time), default=None)
        if near is None or abs(near.time - time) > OLD_S:
            return None
        return near.x, near.y, near.z
