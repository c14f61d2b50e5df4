"""Extended Kalman filter of pose and wheel slip: wheels move it, camera poses correct it, late ones too.

State: x, y, heading, and the share by which each wheel's travel is overstated. Slip changes slowly over the way driven,
so the camera teaches it and the wheels alone drift less while the camera is blind.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rover.geometry import Pose2, wrap_angle

Matrix = NDArray[np.float64]


@dataclass(frozen=True)
class FilterSettings:
    """slip_sigma: of a wheel's slip at the start. slip_walk: its change, per root metre.

    travel_noise: metres per root metre of one wheel. turn_noise: radians per root radian, of scrubbing.
    history: seconds for which late measurements can be taken.
    """

    track_width: float = 0.20
    slip_sigma: float = 0.04
    slip_walk: float = 0.01
    travel_noise: float = 0.003
    turn_noise: float = 0.006
    history: float = 0.6


@dataclass
class _Entry:
    """State before the increments that end at `time`."""

    begin: float
    time: float
    left: float
    right: float
    mean: Matrix
    covariance: Matrix


class WheelFilter:
    """Pose and slip with covariance; `predict` and `correct` in order of their arrival."""

    def __init__(self, start: Pose2, sigma: tuple[float, float, float], settings: FilterSettings) -> None:
        self._settings = settings
        self.mean: Matrix = np.array([start.x, start.y, start.heading, 0.0, 0.0])
        slip = settings.slip_sigma
        self.covariance: Matrix = np.diag([sigma[0] ** 2, sigma[1] ** 2, sigma[2] ** 2, slip**2, slip**2])
        self._time = -math.inf
        self._history: deque[_Entry] = deque()

    @property
    def pose(self) -> Pose2:
        """The newest pose."""
        return _pose(self.mean)

    def predict(self, time: float, left: float, right: float) -> None:
        """Wheel travel in metres that ends at `time`."""
        begin = self._time if math.isfinite(self._time) else time
        self._history.append(_Entry(begin, time, left, right, self.mean.copy(), self.covariance.copy()))
        while self._history and self._history[0].time < time - self._settings.history:
            self._history.popleft()
        self._step(left, right)
        self._time = time

    def at(self, time: float) -> tuple[Matrix, Matrix]:
        """Mean and covariance at a time of the last moments; the newest for later ones."""
        saved = self.mean, self.covariance
        self._rewind(time)
        found = self.mean, self.covariance
        self.mean, self.covariance = saved
        return found

    def correct(self, time: float, pose: Pose2, noise: Matrix, floor: Matrix) -> None:
        """A pose measured at `time` with noise (3, 3). `floor`: covariance (3, 3) of what it was measured against.

        What was placed by a keyframe can't be known better than the keyframe, however often it is looked at.
        """
        later = self._rewind(time)
        h = np.eye(3, 5)
        innovation = np.array([pose.x, pose.y, pose.heading]) - self.mean[:3]
        innovation[2] = wrap_angle(float(innovation[2]))
        s = self.covariance[:3, :3] + noise + floor
        gain = np.linalg.solve(s, self.covariance[:3, :]).T
        self.mean = self.mean + gain @ innovation
        keep = np.eye(5) - gain @ h
        self.covariance = keep @ self.covariance @ keep.T + gain @ (noise + floor) @ gain.T
        self._raise_to(floor)
        self._replay(later)

    def loosen(self, sigma: tuple[float, float, float]) -> None:
        """The pose may be wrong by this much more."""
        self.covariance[:3, :3] += np.diag(np.square(sigma))

    def mahalanobis(self, time: float, pose: Pose2, noise: Matrix) -> float:
        """Squared distance of a measurement from what is expected, in units of its covariance."""
        mean, covariance = self.at(time)
        innovation = np.array([pose.x, pose.y, pose.heading]) - mean[:3]
        innovation[2] = wrap_angle(float(innovation[2]))
        return float(innovation @ np.linalg.solve(covariance[:3, :3] + noise, innovation))

    def _raise_to(self, floor: Matrix) -> None:
        values, vectors = np.linalg.eigh(self.covariance[:3, :3] - floor)
        missing = np.minimum(values, 0.0)
        if missing.any():
            self.covariance[:3, :3] -= (vectors * missing) @ vectors.T

    def _rewind(self, time: float) -> list[_Entry]:
        """Goes back to `time`; the increments after it, the first of them cut, are returned for replay."""
        entries = list(self._history)
        index = len(entries)
        while index and entries[index - 1].time > time:
            index -= 1
        if index == len(entries):
            return []
        entry = entries[index]
        self.mean, self.covariance = entry.mean.copy(), entry.covariance.copy()
        span = entry.time - entry.begin
        share = min(max((time - entry.begin) / span, 0.0), 1.0) if span > 0.0 else 0.0
        if share > 0.0:
            self._step(share * entry.left, share * entry.right)
        rest = 1.0 - share
        left, right = rest * entry.left, rest * entry.right
        first = _Entry(max(time, entry.begin), entry.time, left, right, self.mean.copy(), self.covariance.copy())
        return [first, *entries[index + 1 :]]

    def _replay(self, later: list[_Entry]) -> None:
        kept = [entry for entry in self._history if not later or entry.time < later[0].time]
        self._history = deque(kept)
        for entry in later:
            entry.mean, entry.covariance = self.mean.copy(), self.covariance.copy()
            self._history.append(entry)
            self._step(entry.left, entry.right)

    def _step(self, left: float, right: float) -> None:
        """Moves along an arc; slip lengthens nothing, it shortens what the encoders claim."""
        s = self._settings
        x, y, heading, slip_left, slip_right = self.mean
        dl, dr = left * (1.0 - slip_left), right * (1.0 - slip_right)
        d, turn = 0.5 * (dl + dr), (dr - dl) / s.track_width
        middle = heading + 0.5 * turn
        c, n = math.cos(middle), math.sin(middle)
        self.mean = np.array([x + d * c, y + d * n, heading + turn, slip_left, slip_right])
        f = np.eye(5)
        f[0, 2], f[1, 2] = -d * n, d * c
        # Columns: how x, y, heading change with each wheel's true travel.
        w = np.array(
            [
                [0.5 * c + 0.5 * d * n / s.track_width, 0.5 * c - 0.5 * d * n / s.track_width],
                [0.5 * n - 0.5 * d * c / s.track_width, 0.5 * n + 0.5 * d * c / s.track_width],
                [-1.0 / s.track_width, 1.0 / s.track_width],
            ]
        )
        f[:3, 3], f[:3, 4] = -left * w[:, 0], -right * w[:, 1]
        self.covariance = f @ self.covariance @ f.T
        way = np.array([abs(left), abs(right)])
        self.covariance[:3, :3] += (w * (s.travel_noise**2 * way)) @ w.T
        self.covariance[2, 2] += s.turn_noise**2 * abs(turn)
        walk = s.slip_walk**2 * way
        self.covariance[3, 3] = min(self.covariance[3, 3] + walk[0], 0.01)
        self.covariance[4, 4] = min(self.covariance[4, 4] + walk[1], 0.01)


def _pose(mean: Matrix) -> Pose2:
    return Pose2(float(mean[0]), float(mean[1]), wrap_angle(float(mean[2])))
