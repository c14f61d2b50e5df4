"""The estimated trajectory of a run: the fused pose, and beside it what the wheels alone say."""

from __future__ import annotations

import math
from array import array

import numpy as np
from numpy.typing import NDArray

from rover.geometry import Pose2
from rover.record.relative_error import RelativePose

# A pose with a larger 1σ than this, metres, is none: the rover has not found out yet where it is.
MAX_SIGMA = 1.0


class Track:
    """Poses at the end of every cycle, once there is one. Times in seconds of the companion's clock."""

    def __init__(self) -> None:
        self._first: float | None = None
        self._last = 0.0
        # Flat, eight bytes a number: in two hours there are 360,000 cycles.
        self._fused, self._wheels = array("d"), array("d")
        self._sigmas, self._relative_sigmas = array("d"), array("d")
        # Where the rover believed to be among things, twice a second.
        self.among_things: list[RelativePose] = []

    def add(self, now: float, fused: Pose2, wheels: Pose2, sigma: float, relative_sigma: float) -> None:
        """One cycle; `sigma`: of the position in map, `relative_sigma`: of that among the ground around, metres."""
        self._first, self._last = now if self._first is None else self._first, now
        if sigma > MAX_SIGMA:
            return
        self._fused.extend((now, fused.x, fused.y, fused.heading))
        self._wheels.extend((now, wheels.x, wheels.y, wheels.heading))
        self._sigmas.append(sigma)
        self._relative_sigmas.append(relative_sigma)

    @property
    def fused(self) -> NDArray[np.float64]:
        """(N, 4): time, x, y, heading."""
        return np.array(self._fused).reshape(-1, 4)

    def thinned(self, most: int) -> list[tuple[float, float, float, float]]:
        """At most so many points of `fused`, evenly apart in time, the last one among them."""
        count = len(self._sigmas)
        kept = range(count - 1, -1, -max(1, math.ceil(count / most)))[::-1]
        rows = [self._fused[4 * at : 4 * at + 4] for at in kept]
        return [(t, x, y, heading) for t, x, y, heading in rows]

    @property
    def wheels(self) -> NDArray[np.float64]:
        """(N, 4), from wheel odometry alone."""
        return np.array(self._wheels).reshape(-1, 4)

    @property
    def final_sigma(self) -> float | None:
        """1σ of the last position, metres."""
        return self._sigmas[-1] if self._sigmas else None

    @property
    def max_sigma(self) -> float | None:
        """The largest 1σ of the run, metres."""
        return max(self._sigmas) if self._sigmas else None

    @property
    def max_relative_sigma(self) -> float | None:
        """The largest 1σ of the position among the ground around, metres."""
        return max(self._relative_sigmas) if self._relative_sigmas else None

    @property
    def duration(self) -> float:
        """Seconds from the first cycle to the last."""
        return self._last - self.start

    @property
    def start(self) -> float:
        """When the first cycle ended."""
        return 0.0 if self._first is None else self._first

    @property
    def distance(self) -> float:
        """Metres driven, from poses a tenth of a second apart: noise between closer ones is no way driven."""
        path = self.fused[::5, 1:3]
        return float(np.hypot(*np.diff(path, axis=0).T).sum()) if len(path) > 1 else 0.0

    @property
    def final_pose(self) -> Pose2 | None:
        """Where the rover was at the end."""
        if not self._fused:
            return None
        x, y, heading = self._fused[-3:]
        return Pose2(x, y, math.remainder(heading, 2.0 * math.pi))
