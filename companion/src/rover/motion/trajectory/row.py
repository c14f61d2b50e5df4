"""Segments in the making: whole numbers, and the exact state and pose at their end."""

from __future__ import annotations

import numpy as np
import rover_native
from numpy.typing import NDArray
from rover.motion.path.limits import DrivingLimits
from rover.motion.path.piece import Chain
from rover.motion.segment import MAX_DURATION_US

Array = NDArray[np.float64]

# Metres per second and m/s²: nearer speeds and accelerations are the same.
MIN_SPEED_CHANGE_M_S = 2e-5


class Row:
    """x, y, heading, speed, acceleration, turn_rate, turn_acceleration: at the end; metres, radians, seconds."""

    def __init__(self, x: float, y: float, heading: float) -> None:
        self._row = rover_native.SegmentRow(x, y, heading)
        self._see()

    def __len__(self) -> int:
        return len(self._row)

    def steady(self, most: float, leave: float) -> bool:
        """True when the speed is `most` already and stays so."""
        near = MIN_SPEED_CHANGE_M_S
        return abs(self.speed - most) < near and abs(leave - most) < near and abs(self.acceleration) < near

    def add(self, duration_us: int, jerk_travel: int, jerk_heading: int) -> None:
        """One segment, or a few where it is longer than a segment may be."""
        while duration_us > MAX_DURATION_US:
            self._row.add(MAX_DURATION_US // 2, jerk_travel, jerk_heading)
            duration_us -= MAX_DURATION_US // 2
        self._row.add(duration_us, jerk_travel, jerk_heading)
        self._see()

    def bend(self, side_us: int, level_us: int, jerk_heading: int) -> None:
        """The parts of a corner's curve, without jerk of travel; never the beginning of a run."""
        if level_us:
            signs = ((side_us, 1), (side_us, -1), (level_us, 0), (side_us, -1), (side_us, 1))
        else:
            signs = ((side_us, 1), (2 * side_us, -1), (side_us, 1))  # type: ignore[assignment]
        for duration_us, sign in signs:
            self.add(duration_us, 0, sign * jerk_heading)

    def follow(self, curves: Array, limits: DrivingLimits) -> None:
        """Three segments for each curve of a bend: see `curves_of`."""
        travel, heading = limits.travel, limits.heading
        self._row.follow(curves, (travel.acceleration, travel.jerk), (heading.acceleration, heading.jerk))
        self._see()

    def shares(self, mark: rover_native.RowMark, allowed: tuple[float, ...]) -> Array:
        """(N, 2) of the segments behind a mark: the largest share of what is `allowed` of speeds, and of accelerations
        and jerks."""
        return self._row.shares(mark, allowed)

    def mark(self) -> rover_native.RowMark:
        """Where the row is now, to come back to."""
        return self._row.mark()

    def reset(self, mark: rover_native.RowMark) -> None:
        """Forgets what was added after the mark."""
        self._row.reset(mark)
        self._see()

    def rest(self) -> None:
        """What was added last ends at rest; what comes next begins a run."""
        self._row.rest()
        self._see()

    def fields(self, first: int = 0) -> NDArray[np.int64]:
        """(N, 5) from segment number `first` on: duration in µs, jerks in millionths of the SI unit, 1 where a run
        begins, 1 where it ends at rest."""
        return self._row.fields(first)

    def _see(self) -> None:
        (
            self.x, self.y, self.heading, self.speed, self.acceleration, self.turn_rate, self.turn_acceleration,
        ) = self._row.state  # fmt: skip


def curves_of(chain: Chain, speeds: tuple[Array, Array], ahead: float) -> Array:
    """(N, 10) of the curves of a bend: where each begins and its heading, length and angle, what is to be at its end,
    and the length of what comes behind. `speeds`: and accelerations at the nodes; `ahead`: metres behind the bend."""
    curvature, slope = chain.nodes
    return np.column_stack([
        chain.at, chain.heading, chain.length, chain.angle, speeds[0][1:], speeds[1][1:], curvature[1:], slope[1:],
        np.append(chain.length[1:], ahead),
    ])  # fmt: skip
