"""What segments do, integrated here and not by the code that the rover checks itself with."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from rover.motion.path.limits import DrivingLimits
from rover.motion.segment import Segment

Array = NDArray[np.float64]

# States that each segment is looked at in, its ends among them.
SAMPLES = 40
# What the quantised end of a run may be moving at still, m/s and rad/s.
AT_REST = 1e-5


@dataclass(frozen=True, eq=False)
class Motion:
    """States (N, SAMPLES) of N segments, and positions (N × (SAMPLES − 1) + 1, 2)."""

    speed: Array
    acceleration: Array
    jerk: Array
    turn_rate: Array
    turn_acceleration: Array
    turn_jerk: Array
    positions: Array
    unrest: float


def integrate(segments: Sequence[Segment], x: float, y: float, heading: float) -> Motion:
    """Exact states of each segment, one after the other; positions by Simpson's rule between samples."""
    share = np.linspace(0.0, 1.0, SAMPLES)
    columns: list[list[Array]] = [[] for _ in range(6)]
    positions, unrest = [np.array([[x, y]])], 0.0
    here = np.array([x, y])
    v = a = w = b = 0.0
    for segment in segments:
        t, j, i = share * segment.duration_us * 1e-6, segment.jerk_travel * 1e-6, segment.jerk_heading * 1e-6
        middle = (t[1:] + t[:-1]) / 2.0

        def state(
            at: Array,
            v: float = v,
            a: float = a,
            w: float = w,
            b: float = b,
            j: float = j,
            i: float = i,
            h: float = heading,
        ) -> tuple[Array, Array]:
            return v + at * (a + at * j / 2.0), h + at * (w + at * (b / 2.0 + at * i / 6.0))

        (v1, h1), (v2, h2) = state(t), state(middle)
        weight = np.diff(t) / 6.0
        steps = [weight * (v1[:-1] * f(h1[:-1]) + 4.0 * v2 * f(h2) + v1[1:] * f(h1[1:])) for f in (np.cos, np.sin)]
        track = here + np.cumsum(np.column_stack(steps), axis=0)
        positions.append(track)
        here = track[-1]
        for column, values in zip(
            columns,
            (v1, a + t * j, np.full(SAMPLES, j), w + t * (b + t * i / 2.0), b + t * i, np.full(SAMPLES, i)),
            strict=True,
        ):
            column.append(values)
        v, a, w, b, heading = (
            float(v1[-1]),
            a + t[-1] * j,
            float(w + t[-1] * (b + t[-1] * i / 2.0)),
            b + t[-1] * i,
            float(h1[-1]),
        )
        if segment.rest:
            unrest = max(unrest, abs(v), abs(w))
            v = a = w = b = 0.0
    speed, acceleration, jerk, turn_rate, turn_acceleration, turn_jerk = (np.array(column) for column in columns)
    track = np.concatenate(positions)
    rest = max(unrest, abs(v), abs(w))
    return Motion(speed, acceleration, jerk, turn_rate, turn_acceleration, turn_jerk, track, rest)


def broken(motion: Motion, limits: DrivingLimits) -> list[str]:
    """Names of the limits that are exceeded in any state."""
    rows = (
        ("speed", motion.speed, limits.travel.speed),
        ("acceleration", motion.acceleration, limits.travel.acceleration),
        ("jerk", motion.jerk, limits.travel.jerk),
        ("turn rate", motion.turn_rate, limits.heading.speed),
        ("turn acceleration", motion.turn_acceleration, limits.heading.acceleration),
        ("turn jerk", motion.turn_jerk, limits.heading.jerk),
        ("lateral acceleration", motion.speed * motion.turn_rate, limits.lateral),
    )
    found = [name for name, values, bound in rows if np.abs(values).max(initial=0.0) > bound]
    return found + (["rest at the end"] if motion.unrest > AT_REST else [])


def distance(points: Array, line: Array) -> Array:
    """(M,) of each of the points (M, 2) to the nearest of a polyline (K, 2), in blocks."""
    a, along = line[:-1], np.diff(line, axis=0)
    squared = np.maximum((along**2).sum(axis=1), 1e-18)
    best = np.full(len(points), np.inf)
    block = max(1, 2_000_000 // max(len(a), 1))
    for begin in range(0, len(points), block):
        off = points[begin : begin + block, None] - a
        share = np.clip((off * along).sum(axis=2) / squared, 0.0, 1.0)
        off = off - share[..., None] * along
        best[begin : begin + block] = np.sqrt((off**2).sum(axis=2).min(axis=1))
    return best
