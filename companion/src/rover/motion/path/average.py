"""A polyline averaged over a window that slides along it: the smooth path that dense points stand for.

Q(u) = ∫ P(u + W(u) ξ) K(ξ) dξ with K = 1 − 2 ξ² for |ξ| ≤ 1/2, 2 (1 − |ξ|)² up to 1, and a window W that may change
along the path. Of all K this wide it is the one with the least second derivative: a corner needs the least jerk.
A straight line stays where it is; a circle becomes a circle; steps and noise shorter than the window average out. With
the change of direction Δt at each vertex in the window,

    Q(u) = P(u) + Σ Δt W d(z),   z = (u − u_vertex) / W,   d″ = K outside of the vertex itself,

so Q and its derivatives are sums over vertices: exact, local, and one pass over all of them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Axis:
    """Polylines one after the other on one axis u of arc length, metres, with gaps wider than any window between them.

    `u` (N,), `points` (N, 2): all points; `legs` (N,): the leg that leads on from each, from the last of a polyline the
    one before. `at` (M,), `change` (M, 2): where the direction changes and by how much, in
    order of `at`; vertices mirrored beyond the ends of each polyline, with the change negated, keep the ends in place.
    """

    u: Array
    points: Array
    legs: NDArray[np.int64]
    at: Array
    change: Array


def offsets(axis: Axis, u: Array, window: Array) -> Array:
    """(K, 2): from P(u) to Q(u), metres, at K places with a window of that size each."""
    z, scale, change, rows = _in_window(axis, u, window)
    return _sums(rows, len(u), change, scale * _offset(z))


def averaged(axis: Axis, u: Array, window: Array, slope: Array) -> tuple[Array, Array, Array, Array, Array]:
    """Q and its first four derivatives over u, (K, 2) each. `slope` (K,): of the window over u; what it adds to the
    fourth derivative is left out."""
    z, scale, change, rows = _in_window(axis, u, window)
    count = len(u)
    inclination = slope[rows]
    first, second, third, fourth = _kernel(z)
    base = np.column_stack([np.interp(u, axis.u, axis.points[:, column]) for column in (0, 1)])
    leg = axis.legs[np.clip(np.searchsorted(axis.u, u, side="right") - 1, 0, len(axis.u) - 1)]
    direction = np.diff(axis.points, axis=0)[leg] / np.diff(axis.u)[leg][:, None]
    q = 1.0 - z * inclination
    step = (z >= 0.0).astype(np.float64)
    rate = inclination * (_offset(z) + z * step - z * first)
    value = base + _sums(rows, count, change, scale * _offset(z))
    d1 = direction + _sums(rows, count, change, first - step + rate)
    d2 = _sums(rows, count, change, second * q**2 / scale)
    d3 = _sums(rows, count, change, (third * q**3 - 3.0 * inclination * second * q**2) / scale**2)
    d4 = _sums(rows, count, change, fourth / scale**3)
    return value, d1, d2, d3, d4


def _in_window(axis: Axis, u: Array, window: Array) -> tuple[Array, Array, Array, NDArray[np.int64]]:
    """z, window, change and row of each pair of a place and a vertex in its window."""
    begin = np.searchsorted(axis.at, u - window, side="right")
    count = np.maximum(np.searchsorted(axis.at, u + window, side="left") - begin, 0)
    rows = np.repeat(np.arange(len(u)), count)
    number = np.arange(len(rows)) - np.repeat(np.cumsum(count) - count, count) + begin[rows]
    scale = window[rows]
    return (u[rows] - axis.at[number]) / scale, scale, axis.change[number], rows


def _sums(rows: NDArray[np.int64], count: int, change: Array, weight: Array) -> Array:
    columns = [np.bincount(rows, weights=change[:, column] * weight, minlength=count) for column in (0, 1)]
    return np.column_stack(columns)


def _offset(z: Array) -> Array:
    """d(z): zero from |z| = 1 on."""
    t = np.minimum(np.abs(z), 1.0)
    return np.where(t <= 0.5, 0.875 / 6.0 - t * (0.5 - t * (0.5 - t * t / 6.0)), (1.0 - t) ** 4 / 6.0)


def _kernel(z: Array) -> tuple[Array, Array, Array, Array]:
    """The integral of K up to z, K and its first two derivatives."""
    t = np.minimum(np.abs(z), 1.0)
    near, sign = t <= 0.5, np.sign(z)
    half = np.where(near, t * (1.0 - t * t / 1.5), 0.5 - (1.0 - t) ** 3 / 1.5)
    value = np.where(near, 1.0 - 2.0 * t * t, 2.0 * (1.0 - t) ** 2)
    slope = -4.0 * sign * np.where(near, t, 1.0 - t)
    return 0.5 + sign * half, value, slope, np.where(near, -4.0, 4.0)
