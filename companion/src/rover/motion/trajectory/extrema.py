"""How much a row of quantised segments asks of both axes, all segments at once, against the limits."""

from __future__ import annotations

from dataclasses import astuple, dataclass

import numpy as np
from numpy.typing import NDArray
from rover.motion.path.limits import DrivingLimits

Array = NDArray[np.float64]


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

    @classmethod
    def allowed(cls, limits: DrivingLimits) -> Extrema:
        """The most that each may be."""
        travel, heading = limits.travel, limits.heading
        return cls(
            travel.speed,
            travel.acceleration,
            travel.jerk,
            heading.speed,
            heading.acceleration,
            heading.jerk,
            limits.lateral,
        )

    def broken(self, limits: DrivingLimits) -> str:
        """Which limit is exceeded, in words; empty when none is."""
        names = ("speed", "acceleration", "jerk", "turn rate", "turn acceleration", "turn jerk", "lateral acceleration")
        for name, value, bound in zip(names, astuple(self), astuple(Extrema.allowed(limits)), strict=True):
            if not value <= bound:
                return f"{name} of {value:.6g} exceeds {bound:g}"
        return ""


def magnitudes(t: Array, jerk: Array, turn_jerk: Array, rest: NDArray[np.bool_]) -> tuple[Array, ...]:
    """Of each of N segments, from rest, the largest magnitudes (N,) in the order of Extrema."""
    v0, a0, _ = axis_states(t, jerk, rest)
    w0, b0, _ = axis_states(t, turn_jerk, rest)
    travel, turning = _most(t, v0, a0, jerk), _most(t, w0, b0, turn_jerk)
    # Both at their largest in the same segment: never less than the product at any time.
    return (*travel, *turning, travel[0] * turning[0])


def axis_states(t: Array, jerk: Array, rest: NDArray[np.bool_]) -> tuple[Array, Array, Array]:
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
