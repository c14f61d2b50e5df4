"""What quantised segments really do: extrema of both axes, and where the rover goes, against the limits and the path.

Integrated from the integers that are sent, all at once; nothing of the plan is taken on trust.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from rover.motion.path.blend import Piece
from rover.motion.path.clearance import ClearanceMap
from rover.motion.path.limits import DrivingLimits
from rover.motion.trajectory.plan import Trajectory

Array = NDArray[np.float64]

# Parts that a segment which turns is cut into; two-point Gauss quadrature in each leaves less than 0.1 µm.
PARTS_PER_SEGMENT = 8
# Metres: a path may touch what it goes around, and whole microseconds put the rover beside it by less than this.
ROUNDING_M = 2e-5
_GAUSS, _WEIGHTS = np.polynomial.legendre.leggauss(2)


@dataclass(frozen=True)
class Extrema:
    """Largest magnitudes (SI) over all segments; `lateral` is speed × turn rate."""

    speed: float
    acceleration: float
    jerk: float
    turn_rate: float
    turn_acceleration: float
    turn_jerk: float
    lateral: float

    def broken(self, limits: DrivingLimits) -> str:
        """Which limit is exceeded, in words; empty when none is."""
        for name, value, bound in (
            ("speed", self.speed, limits.travel.speed),
            ("acceleration", self.acceleration, limits.travel.acceleration),
            ("jerk", self.jerk, limits.travel.jerk),
            ("turn rate", self.turn_rate, limits.heading.speed),
            ("turn acceleration", self.turn_acceleration, limits.heading.acceleration),
            ("turn jerk", self.turn_jerk, limits.heading.jerk),
            ("lateral acceleration", self.lateral, limits.lateral),
        ):
            if not value <= bound:
                return f"{name} of {value:.6g} exceeds {bound:g}"
        return ""


class Driven:
    """The motion of a trajectory. `points` (M, 2): where it passes, with chords that the way leaves by
    at most `bulges` (M - 1).

    `poses` (N + 1, 3): x, y, heading at the beginning of each of the N segments and at the end of the last.
    """

    def __init__(self, trajectory: Trajectory) -> None:
        segments = trajectory.segments
        t = 1e-6 * np.array([segment.duration_us for segment in segments], dtype=np.float64)
        jerk = 1e-6 * np.array([segment.jerk_travel for segment in segments], dtype=np.float64)
        turn_jerk = 1e-6 * np.array([segment.jerk_heading for segment in segments], dtype=np.float64)
        rest = np.array([segment.rest for segment in segments], dtype=np.bool_)
        v0, a0, way = _axis(t, jerk, rest)
        w0, b0, turned = _axis(t, turn_jerk, rest)
        travel, turning = _most(t, v0, a0, jerk), _most(t, w0, b0, turn_jerk)
        # Both at their largest in the same segment: never less than the product at any time.
        lateral = travel[0] * turning[0]
        self.extrema = Extrema(*(float(np.max(each, initial=0.0)) for each in (*travel, *turning, lateral)))
        heading = trajectory.heading + np.concatenate([[0.0], np.cumsum(turned)])
        bends = (turned != 0.0) & (way != 0.0)
        step_x, step_y = way * np.cos(heading[:-1]), way * np.sin(heading[:-1])
        parts = _parts(
            t[bends], (v0[bends], a0[bends], jerk[bends]), (heading[:-1][bends], w0[bends], b0[bends], turn_jerk[bends])
        )
        step_x[bends], step_y[bends] = parts.sum(axis=1).T
        x = trajectory.x + np.concatenate([[0.0], np.cumsum(step_x)])
        y = trajectory.y + np.concatenate([[0.0], np.cumsum(step_y)])
        self.poses: Array = np.column_stack([x, y, heading])
        # A chord is left by at most an eighth of its time squared times the acceleration across it.
        across = lateral + travel[1] * np.minimum(np.abs(turned), 1.0)
        bulge = np.where(bends, across * (t / PARTS_PER_SEGMENT) ** 2 / 8.0, 0.0)
        inner = self.poses[:-1][bends, None, :2] + np.cumsum(parts[:, :-1], axis=1)
        order = np.concatenate([np.arange(len(x)), np.repeat(np.flatnonzero(bends) + 0.5, PARTS_PER_SEGMENT - 1)])
        sorting = np.argsort(order, kind="stable")
        self.points: Array = np.concatenate([self.poses[:, :2], inner.reshape(-1, 2)])[sorting]
        self.bulges: Array = bulge[order[sorting][:-1].astype(np.int64)]

    def off_pieces(self, pieces: Sequence[Piece], starts: Sequence[int]) -> float:
        """Largest distance from where each piece should begin, metres. `starts`: of the trajectory."""
        if not starts:
            return 0.0
        wanted = np.array([(piece.x, piece.y) for piece in pieces[: len(starts)]])
        return float(np.hypot(*(self.poses[list(starts), :2] - wanted).T).max())

    def off_polyline(self, path: ArrayLike) -> float:
        """Largest distance from a polyline (K, 2) that is followed in order, metres."""
        line = np.asarray(path, dtype=np.float64).reshape(-1, 2)
        return float(distance_to_polyline(self.points, line).max(initial=0.0) + self.bulges.max(initial=0.0))

    def swept_clear(self, clearance: ClearanceMap) -> bool:
        """True when the footprint touches nothing along the whole way, but for ROUNDING_M."""
        a, b = self.points[:-1], self.points[1:]
        moves = np.hypot(*(b - a).T) > 1e-9
        return bool(clearance.swept(a[moves], b[moves], self.bulges[moves] - ROUNDING_M).all())


def _axis(t: Array, jerk: Array, rest: NDArray[np.bool_]) -> tuple[Array, Array, Array]:
    """Speed and acceleration at the beginning of each segment and the way it makes; zero after each that rests."""
    after = np.flatnonzero(rest)
    last = np.zeros(len(t), dtype=np.int64)
    last[after[after + 1 < len(t)] + 1] = after[after + 1 < len(t)] + 1
    last = np.maximum.accumulate(last) if len(t) else last
    sums = np.concatenate([[0.0], np.cumsum(jerk * t)])
    a0: Array = sums[:-1] - sums[last]
    sums = np.concatenate([[0.0], np.cumsum(t * (a0 + 0.5 * t * jerk))])
    v0: Array = sums[:-1] - sums[last]
    return v0, a0, t * (v0 + t * (a0 / 2.0 + t * jerk / 6.0))


def _most(t: Array, v0: Array, a0: Array, jerk: Array) -> tuple[Array, Array, Array]:
    """Largest magnitudes of speed, acceleration and jerk in each segment: at its ends, or where speed has its peak."""
    end = a0 + t * jerk
    peak = np.clip(np.divide(-a0, jerk, out=np.zeros_like(t), where=jerk != 0.0), 0.0, t)
    speed = np.maximum(np.abs(v0), np.abs(v0 + 0.5 * t * (a0 + end)))
    speed = np.maximum(speed, np.abs(v0 + peak * (a0 + 0.5 * peak * jerk)))
    return speed, np.maximum(np.abs(a0), np.abs(end)), np.abs(jerk)


def _parts(t: Array, travel: tuple[Array, Array, Array], heading: tuple[Array, Array, Array, Array]) -> Array:
    """(N, PARTS_PER_SEGMENT, 2): displacement in each part of segments that turn while driving."""
    v0, a0, jerk = (each[:, None, None] for each in travel)
    h0, w0, b0, turn_jerk = (each[:, None, None] for each in heading)
    at = (np.arange(PARTS_PER_SEGMENT)[:, None] + (_GAUSS + 1.0) / 2.0) / PARTS_PER_SEGMENT * t[:, None, None]
    direction = h0 + at * (w0 + at * (b0 / 2.0 + at * turn_jerk / 6.0))
    speed = (v0 + at * (a0 + at * jerk / 2.0)) * (t[:, None, None] / (2.0 * PARTS_PER_SEGMENT))
    return np.stack([(speed * np.cos(direction)) @ _WEIGHTS, (speed * np.sin(direction)) @ _WEIGHTS], axis=-1)


def distance_to_polyline(points: Array, line: Array) -> Array:
    """(M,) distance of each of (M, 2) points to the nearest point of a polyline (K, 2), metres."""
    if len(line) < 2:
        target = line[0] if len(line) else np.zeros(2)
        offset = points - target
        return np.asarray(np.hypot(offset[:, 0], offset[:, 1]), dtype=np.float64)
    best = np.full(len(points), math.inf)
    for a, b in itertools.pairwise(line):
        along = b - a
        squared = max(float(along @ along), 1e-18)
        share = np.clip((points - a) @ along / squared, 0.0, 1.0)
        best = np.minimum(best, np.hypot(*(points - a - share[:, None] * along).T))
    return best
