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
import rover_native
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


def averaged(axis: Axis, u: Array, window: Array, slope: Array) -> tuple[Array, Array, Array, Array, Array]:
    """Q and its first four derivatives over u at K places, (K, 2) each. `slope` (K,): of the window over u; what it adds
    to the fourth derivative is left out."""
    line = (axis.u, axis.points, axis.legs, axis.at, axis.change)
    found = rover_native.averaged(line, u, window, slope)
    return found[:, 0:2], found[:, 2:4], found[:, 4:6], found[:, 6:8], found[:, 8:10]
