"""What quantised segments really do: where the rover goes, integrated from the integers that are sent, all at once.

Nothing of the plan is taken on trust.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from rover.motion.path.clearance import ClearanceMap
from rover.motion.trajectory.extrema import Extrema, axis_states, magnitudes
from rover.motion.trajectory.plan import Trajectory

Array = NDArray[np.float64]

# Parts that a segment which turns is cut into; two-point Gauss quadrature in each leaves less than 0.1 µm.
PARTS_PER_SEGMENT = 8
# Metres: a path may touch what it goes around, and whole microseconds put the rover beside it by less than this.
ROUNDING_M = 2e-5
_GAUSS, _WEIGHTS = np.polynomial.legendre.leggauss(2)


class Driven:
    """The motion of a trajectory. `points` (M, 2): where it passes, with chords that the way leaves by
    at most `bulges` (M - 1).

    `segments` (M,): the segment that each point is in. `poses` (N + 1, 3): x, y, heading at the beginning of each of
    the N segments and at the end of the last.
    """

    def __init__(self, trajectory: Trajectory) -> None:
        segments = trajectory.segments
        t = 1e-6 * np.array([segment.duration_us for segment in segments], dtype=np.float64)
        jerk = 1e-6 * np.array([segment.jerk_travel for segment in segments], dtype=np.float64)
        turn_jerk = 1e-6 * np.array([segment.jerk_heading for segment in segments], dtype=np.float64)
        rest = np.array([segment.rest for segment in segments], dtype=np.bool_)
        v0, a0, way = axis_states(t, jerk, rest)
        w0, b0, turned = axis_states(t, turn_jerk, rest)
        most = magnitudes(t, jerk, turn_jerk, rest)
        lateral = most[-1]
        self.extrema = Extrema(*(float(np.max(each, initial=0.0)) for each in most))
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
        across = lateral + most[1] * np.minimum(np.abs(turned), 1.0)
        bulge = np.where(bends, across * (t / PARTS_PER_SEGMENT) ** 2 / 8.0, 0.0)
        inner = self.poses[:-1][bends, None, :2] + np.cumsum(parts[:, :-1], axis=1)
        order = np.concatenate([np.arange(len(x)), np.repeat(np.flatnonzero(bends) + 0.5, PARTS_PER_SEGMENT - 1)])
        sorting = np.argsort(order, kind="stable")
        self.points: Array = np.concatenate([self.poses[:, :2], inner.reshape(-1, 2)])[sorting]
        self.segments: NDArray[np.int64] = order[sorting].astype(np.int64)
        self.bulges: Array = bulge[self.segments[:-1]]

    def touching(self, clearance: ClearanceMap) -> Array:
        """(K, 2): where the footprint touches something, but for ROUNDING_M; none when it is clear all the way."""
        a, b = self.points[:-1], self.points[1:]
        moves = np.hypot(*(b - a).T) > 1e-9
        clear = clearance.swept(a[moves], b[moves], self.bulges[moves] - ROUNDING_M)
        return np.asarray(a[moves][~clear], dtype=np.float64)


def _parts(t: Array, travel: tuple[Array, Array, Array], heading: tuple[Array, Array, Array, Array]) -> Array:
    """(N, PARTS_PER_SEGMENT, 2): displacement in each part of segments that turn while driving."""
    v0, a0, jerk = (each[:, None, None] for each in travel)
    h0, w0, b0, turn_jerk = (each[:, None, None] for each in heading)
    at = (np.arange(PARTS_PER_SEGMENT)[:, None] + (_GAUSS + 1.0) / 2.0) / PARTS_PER_SEGMENT * t[:, None, None]
    direction = h0 + at * (w0 + at * (b0 / 2.0 + at * turn_jerk / 6.0))
    speed = (v0 + at * (a0 + at * jerk / 2.0)) * (t[:, None, None] / (2.0 * PARTS_PER_SEGMENT))
    return np.stack([(speed * np.cos(direction)) @ _WEIGHTS, (speed * np.sin(direction)) @ _WEIGHTS], axis=-1)
