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
    one before. `vertices` (M,), `change` (M, 2): where the direction changes and by how much, in
    order; vertices mirrored beyond the ends of each polyline, with the change negated, keep the ends in place.
    """

    u: Array
    points: Array
    legs: NDArray[np.int64]
    vertices: Array
    change: Array

    def at(self, u: Array, window: Array, slope: Array) -> tuple[Array, Array]:
        """Q and its derivative over u at K places, (K, 2) each. `slope` (K,): of the window over u."""
        found = rover_native.averaged(self._line, (u, window, slope))
        return found[:, :2], found[:, 2:]

    def bending(self, u: Array, window: Array) -> tuple[Array, Array, Array, Array]:
        """How far Q is from the polyline at K places, and the magnitudes of its curvature and of the first two
        derivatives of that over arc length, (K,) each."""
        off, curvature, rate, third = rover_native.averaged_bending(self._line, (u, window, np.zeros(len(u))))
        return off, curvature, rate, third

    @property
    def _line(self) -> tuple[Array, Array, NDArray[np.int64], Array, Array]:
        return self.u, self.points, self.legs, self.vertices, self.change
