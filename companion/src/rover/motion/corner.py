"""The curve that rounds a corner: five equal parts of constant third derivative of heading over arc length.

Driven at constant speed v its heading is a row of five constant-jerk segments (jerk = v³ times that derivative), so the
firmware drives this very curve and no approximation of it. Curvature rises and falls along generalised clothoids and is
level in the middle fifth; curvature, its slope and the heading's acceleration are continuous. Over the unit interval

    φ''' = 41.7 · (+1, −1, 0, −1, +1),   φ(0) = 0, φ(1) = 1,   most φ' = 5/3, most φ'' = 25/3.

A corner of angle θ and length L has heading θ φ(s/L). All functions take arrays, one element a corner.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

PARTS = 5
SIGNS = (1.0, -1.0, 0.0, -1.0, 1.0)
PEAK_CURVATURE = 5.0 / 3.0  # times θ / L
PEAK_SLOPE = 25.0 / 3.0  # times θ / L²
PEAK_THIRD = 125.0 / 3.0  # times θ / L³

# φ, φ', φ'' at the beginning of each part.
_AT_START = (
    (0.0, 0.0, 0.0),
    (1 / 18, 5 / 6, 25 / 3),
    (1 / 3, 5 / 3, 0.0),
    (2 / 3, 5 / 3, 0.0),
    (17 / 18, 5 / 6, -25 / 3),
)
_STARTS = np.array(_AT_START)
_SIGNS = np.array(SIGNS)


def turned(u: Array) -> Array:
    """φ: the share of the corner's angle that is turned after the share `u` of its length."""
    u = np.clip(u, 0.0, 1.0)
    part = np.minimum((u * PARTS).astype(np.int64), PARTS - 1)
    r = u - part / PARTS
    at = _STARTS[part]
    result: Array = at[..., 0] + r * (at[..., 1] + r * (at[..., 2] / 2.0 + r * _SIGNS[part] * PEAK_THIRD / 6.0))
    return result


def derivatives(u: float) -> tuple[float, float, float, float]:
    """φ, φ', φ'', φ''' at the share `u` of the length, a number."""
    part = min(int(max(u, 0.0) * PARTS), PARTS - 1)
    r = min(max(u, 0.0), 1.0) - part / PARTS
    third = SIGNS[part] * PEAK_THIRD
    value, first, second = _AT_START[part]
    return (
        value + r * (first + r * (second / 2.0 + r * third / 6.0)),
        first + r * (second + r * third / 2.0),
        second + r * third,
        third,
    )


# Simpson's rule over half the curve: the other half mirrors it.
_HALF = 16
_NODES = np.linspace(0.0, 0.5, _HALF + 1)
_WEIGHTS = np.array([1.0, *([4.0, 2.0] * (_HALF // 2))[: _HALF - 1], 1.0]) / (3.0 * _HALF) / 2.0
_FROM_MIDDLE = 0.5 - turned(_NODES)


def tangent_and_cut(angle: Array) -> tuple[Array, Array]:
    """Per metre of curve: from the corner to where the curve leaves its leg, and from the corner to the curve.

    `angle`: radians, |angle| < π.
    """
    angle = np.abs(angle)
    offsets = angle[:, None] * _FROM_MIDDLE
    half_chord = np.cos(offsets) @ _WEIGHTS
    depth = np.sin(offsets) @ _WEIGHTS
    half = angle / 2.0
    return half_chord / np.cos(half), half_chord * np.tan(half) - depth


_GAUSS, _GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(2)


def points(x: Array, y: Array, heading: Array, angle: Array, length: Array, count: int) -> Array:
    """(N, count + 1, 2): points at equal distances along each of N curves that begin at (x, y) in `heading`."""
    edges = np.linspace(0.0, 1.0, count + 1)
    step = 1.0 / count
    nodes = edges[:-1, None] + step * (_GAUSS + 1.0) / 2.0
    phi = turned(nodes)
    directions = heading[:, None, None] + angle[:, None, None] * phi
    scale = length[:, None] * (step / 2.0)
    result = np.empty((len(x), count + 1, 2))
    for axis, (origin, steps) in enumerate(
        ((x, (np.cos(directions) @ _GAUSS_WEIGHTS) * scale), (y, (np.sin(directions) @ _GAUSS_WEIGHTS) * scale))
    ):
        result[:, 0, axis] = origin
        result[:, 1:, axis] = origin[:, None] + np.cumsum(steps, axis=1)
    return result
