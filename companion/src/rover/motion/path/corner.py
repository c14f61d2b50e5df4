"""The curve that rounds a corner: parts of constant third derivative of heading over arc length, + − 0 − +.

Driven at constant speed v its heading is a row of constant-jerk segments (jerk = v³ times that derivative), so the
firmware drives this very curve and no approximation of it. Curvature rises and falls along generalised clothoids and is
level in between; curvature, its slope and the heading's acceleration are continuous. Over the unit interval the level
part has the share m, each of the others r = (1 − m)/4, and φ(0) = 0, φ(1) = 1:

    φ''' = P · (+1, −1, 0, −1, +1),   P = 1 / (r² (2r + m)),   most φ' = P r², most φ'' = P r.

The shorter the level part, the less jerk and the more curvature a corner needs: small corners are bound by the one,
large ones by the other, so there are several shapes (LEVELS). A corner of angle θ and length L has heading θ φ(s/L).
Functions take arrays, one element a corner; `shape` is an index into LEVELS.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Shapes = NDArray[np.int64]

LEVELS = (0.0, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35)
SIGNS = (1.0, -1.0, 0.0, -1.0, 1.0)

_LEVEL = np.array(LEVELS)
SIDE = (1.0 - _LEVEL) / 4.0
# Times θ / L³.
PEAK_THIRD = 1.0 / (SIDE**2 * (2.0 * SIDE + _LEVEL))
# Times θ / L².
PEAK_SLOPE = PEAK_THIRD * SIDE
# Times θ / L.
PEAK_CURVATURE = PEAK_SLOPE * SIDE


def _starts(level: float, side: float, third: float) -> list[tuple[float, float, float, float]]:
    """u, φ, φ', φ'' at the beginning of each part."""
    found = []
    u = value = first = second = 0.0
    for sign, width in zip(SIGNS, (side, side, level, side, side), strict=True):
        found.append((u, value, first, second))
        jerk = sign * third
        value += width * (first + width * (second / 2.0 + width * jerk / 6.0))
        first += width * (second + width * jerk / 2.0)
        second += width * jerk
        u += width
    return found


_STARTS = [_starts(*each) for each in zip(LEVELS, SIDE.tolist(), PEAK_THIRD.tolist(), strict=True)]
_EDGES = [[start[0] for start in starts[1:]] for starts in _STARTS]
_START_ARRAY, _EDGE_ARRAY, _SIGN_ARRAY = np.array(_STARTS), np.array(_EDGES), np.array(SIGNS)


def turned(u: Array, shape: int) -> Array:
    """φ: the share of the corner's angle that is turned after the share `u` of its length."""
    u = np.clip(u, 0.0, 1.0)
    part = np.searchsorted(_EDGE_ARRAY[shape], u, side="right")
    at = _START_ARRAY[shape][part]
    r = u - at[..., 0]
    third = _SIGN_ARRAY[part] * PEAK_THIRD[shape]
    result: Array = at[..., 1] + r * (at[..., 2] + r * (at[..., 3] / 2.0 + r * third / 6.0))
    return result


def parts(angle: float, length: float, shape: int) -> tuple[tuple[float, float], ...]:
    """(length, third derivative of heading over arc length) of each part of a corner's curve."""
    side, level, third = float(SIDE[shape]) * length, LEVELS[shape] * length, float(PEAK_THIRD[shape])
    jerk = third * angle / length**3
    if level > 0.0:
        return (side, jerk), (side, -jerk), (level, 0.0), (side, -jerk), (side, jerk)
    return (side, jerk), (2.0 * side, -jerk), (side, jerk)


def _half_curve(shape: int) -> tuple[Array, Array]:
    """0.5 − φ at the nodes of a quadrature over the first half of the curve, part by part, and its weights."""
    nodes, weights = np.polynomial.legendre.leggauss(5)
    edges = np.array([0.0, *_EDGES[shape][:2], 0.5])
    widths = np.diff(edges)[:, None]
    u = edges[:-1, None] + widths * (nodes + 1.0) / 2.0
    return 0.5 - turned(u.ravel(), shape), (widths * weights / 2.0).ravel()


# The other half mirrors the first.
_HALVES = [_half_curve(shape) for shape in range(len(LEVELS))]
_FROM_MIDDLE, _WEIGHTS = np.array([each[0] for each in _HALVES]), np.array([each[1] for each in _HALVES])


def tangent_and_cut(angle: Array, shape: Shapes) -> tuple[Array, Array]:
    """Per metre of curve: from the corner to where the curve leaves its leg, and from the corner to the curve.

    `angle`: radians, |angle| < π.
    """
    angle = np.abs(angle)
    offsets = angle[:, None] * _FROM_MIDDLE[shape]
    weights = _WEIGHTS[shape]
    half_chord = (np.cos(offsets) * weights).sum(axis=1)
    depth = (np.sin(offsets) * weights).sum(axis=1)
    half = angle / 2.0
    return half_chord / np.cos(half), half_chord * np.tan(half) - depth


_GAUSS, _GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(2)


@lru_cache(maxsize=8)
def _turned_at_nodes(count: int) -> Array:
    """(shapes, count, 2): φ at the Gauss nodes of `count` equal parts."""
    nodes = (np.arange(count)[:, None] + (_GAUSS + 1.0) / 2.0) / count
    return np.array([turned(nodes, shape) for shape in range(len(LEVELS))])


def points(x: Array, y: Array, heading: Array, angle: Array, length: Array, shape: Shapes, count: int) -> Array:
    """(N, count + 1, 2): points at equal distances along each of N curves that begin at (x, y) in `heading`."""
    directions = heading[:, None, None] + angle[:, None, None] * _turned_at_nodes(count)[shape]
    scale = length[:, None] / (2.0 * count)
    result = np.empty((len(x), count + 1, 2))
    for axis, (origin, steps) in enumerate(
        ((x, (np.cos(directions) @ _GAUSS_WEIGHTS) * scale), (y, (np.sin(directions) @ _GAUSS_WEIGHTS) * scale))
    ):
        result[:, 0, axis] = origin
        result[:, 1:, axis] = origin[:, None] + np.cumsum(steps, axis=1)
    return result
