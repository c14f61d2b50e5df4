"""Segments in the making: plain numbers, and the exact state and pose at their end."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import rover_native
from numpy.typing import NDArray
from rover.motion.path.limits import DrivingLimits
from rover.motion.path.piece import Chain
from rover.motion.segment import MAX_DURATION_US

Array = NDArray[np.float64]

# Metres per second and m/s²: nearer speeds and accelerations are the same.
MIN_SPEED_CHANGE_M_S = 2e-5
# A segment that turns by more is integrated in parts.
MAX_STEP_RAD = 0.4

# Nodes and weights of three-point Gauss quadrature on [0, 1].
_NODES = (0.5 - math.sqrt(0.15), 0.5, 0.5 + math.sqrt(0.15))
_WEIGHTS = (5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0)


class Mark(NamedTuple):
    """A place in a row: how many segments come before, pose, speeds and accelerations, whether a run begins there."""

    segments: int
    pose: tuple[float, float, float]
    state: tuple[float, float, float, float]
    begin: bool


class Row:
    """`numbers`: the fields of each segment; metres, radians, seconds otherwise."""

    def __init__(self, x: float, y: float, heading: float) -> None:
        self.numbers: list[tuple[int, int, int, bool, bool]] = []
        self.x, self.y, self.heading = x, y, heading
        self.speed = self.acceleration = self.turn_rate = self.turn_acceleration = 0.0
        self._begin = True

    def steady(self, most: float, leave: float) -> bool:
        """True when the speed is `most` already and stays so."""
        near = MIN_SPEED_CHANGE_M_S
        return abs(self.speed - most) < near and abs(leave - most) < near and abs(self.acceleration) < near

    def add(self, duration_us: int, jerk_travel: int, jerk_heading: int) -> None:
        """One segment, or a few where it is longer than a segment may be."""
        while duration_us > MAX_DURATION_US:
            self.add(MAX_DURATION_US // 2, jerk_travel, jerk_heading)
            duration_us -= MAX_DURATION_US // 2
        self.numbers.append((duration_us, jerk_travel, jerk_heading, self._begin, False))
        self._begin = False
        self._move(duration_us * 1e-6, jerk_travel * 1e-6, jerk_heading * 1e-6)

    def bend(self, side_us: int, level_us: int, jerk_heading: int) -> None:
        """The parts of a corner's curve, without jerk of travel; never the beginning of a run."""
        if level_us:
            signs = ((side_us, 1), (side_us, -1), (level_us, 0), (side_us, -1), (side_us, 1))
        else:
            signs = ((side_us, 1), (2 * side_us, -1), (side_us, 1))  # type: ignore[assignment]
        for duration_us, sign in signs:
            self.add(duration_us, 0, sign * jerk_heading)

    def follow(self, chain: Chain, speeds: tuple[Array, Array], ahead: float, limits: DrivingLimits) -> None:
        """Three segments for each curve of a bend. `speeds`: and accelerations at its nodes; `ahead`: metres of what
        comes behind it."""
        curvature, slope = chain.at_nodes()
        curves = np.column_stack([
            chain.at, chain.heading, chain.length, chain.angle, speeds[0][1:], speeds[1][1:], curvature[1:], slope[1:],
            np.append(chain.length[1:], ahead),
        ])  # fmt: skip
        state = (
            self.x, self.y, self.heading, self.speed, self.acceleration, self.turn_rate, self.turn_acceleration,
        )  # fmt: skip
        found, end = rover_native.drive_bend(
            state, curves, (limits.travel.acceleration, limits.travel.jerk),
            (limits.heading.acceleration, limits.heading.jerk),
        )  # fmt: skip
        rows = [(duration, jerk, turn, False, False) for duration, jerk, turn in found.tolist()]
        rows[0] = (*rows[0][:3], self._begin, False)
        self._begin = False
        self.numbers += rows
        (
            self.x, self.y, self.heading, self.speed, self.acceleration, self.turn_rate, self.turn_acceleration,
        ) = end  # fmt: skip

    def mark(self) -> Mark:
        """Where the row is now, to come back to."""
        state = (self.speed, self.acceleration, self.turn_rate, self.turn_acceleration)
        return Mark(len(self.numbers), (self.x, self.y, self.heading), state, self._begin)

    def reset(self, mark: Mark) -> None:
        """Forgets what was added after the mark."""
        del self.numbers[mark.segments :]
        self.x, self.y, self.heading = mark.pose
        self.speed, self.acceleration, self.turn_rate, self.turn_acceleration = mark.state
        self._begin = mark.begin

    def rest(self) -> None:
        """What was added last ends at rest; what comes next begins a run."""
        if not self._begin:
            self.numbers[-1] = (*self.numbers[-1][:4], True)
            self.speed = self.acceleration = self.turn_rate = self.turn_acceleration = 0.0
            self._begin = True

    def _move(self, t: float, j: float, i: float) -> None:
        v, a, w, b = self.speed, self.acceleration, self.turn_rate, self.turn_acceleration
        turned = t * (w + t * (b / 2.0 + t * i / 6.0))
        if w == 0.0 and b == 0.0 and i == 0.0:
            way = t * (v + t * (a / 2.0 + t * j / 6.0))
            self.x += way * math.cos(self.heading)
            self.y += way * math.sin(self.heading)
        elif v != 0.0 or a != 0.0 or j != 0.0:
            parts = 1 + int((abs(turned) + t * abs(w)) / MAX_STEP_RAD)
            step = t / parts
            for part in range(parts):
                for node, weight in zip(_NODES, _WEIGHTS, strict=True):
                    r = (part + node) * step
                    way = weight * step * (v + r * (a + r * j / 2.0))
                    heading = self.heading + r * (w + r * (b / 2.0 + r * i / 6.0))
                    self.x += way * math.cos(heading)
                    self.y += way * math.sin(heading)
        self.heading += turned
        self.speed = v + t * (a + t * j / 2.0)
        self.acceleration = a + t * j
        self.turn_rate = w + t * (b + t * i / 2.0)
        self.turn_acceleration = b + t * i
