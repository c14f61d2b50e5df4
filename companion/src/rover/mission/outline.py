"""The outline of an area: a polygon, its corners in map, metres."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Point = tuple[float, float]

# Half the width of the strip that leads from a launch outside into the area, metres: the rover turns in it.
STRIP_M = 0.5


def inside(polygon: tuple[Point, ...], point: Point) -> bool:
    """Whether a point lies in a polygon."""
    return bool(contains(polygon, np.array([point[0]]), np.array([point[1]]))[0])


def contains(polygon: tuple[Point, ...], x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Even-odd rule: a ray to the right crosses the outline an odd number of times."""
    odd = np.zeros(np.broadcast_shapes(x.shape, y.shape), bool)
    for (ax, ay), (bx, by) in zip(polygon, (*polygon[1:], polygon[0]), strict=True):
        if ay != by:
            crosses = (ay > y) != (by > y)
            odd ^= crosses & (x < ax + (y - ay) * ((bx - ax) / (by - ay)))
    return odd


def nearest(polygon: tuple[Point, ...], point: Point) -> Point:
    """The point of the outline nearest to a point."""
    best, at = np.inf, polygon[0]
    for a, b in zip(polygon, (*polygon[1:], polygon[0]), strict=True):
        along = _along(np.array(point[0]), np.array(point[1]), a, b)
        foot = (a[0] + float(along) * (b[0] - a[0]), a[1] + float(along) * (b[1] - a[1]))
        away = float(np.hypot(foot[0] - point[0], foot[1] - point[1]))
        if away < best:
            best, at = away, foot
    return at


def _along(x: NDArray[np.float64], y: NDArray[np.float64], a: Point, b: Point) -> NDArray[np.float64]:
    """Where on a segment, 0 to 1, the foot of each point lies."""
    dx, dy = b[0] - a[0], b[1] - a[1]
    return np.clip(((x - a[0]) * dx + (y - a[1]) * dy) / max(dx * dx + dy * dy, 1e-12), 0.0, 1.0)


def distance_to_segment(x: NDArray[np.float64], y: NDArray[np.float64], a: Point, b: Point) -> NDArray[np.float64]:
    along = _along(x, y, a, b)
    return np.hypot(x - (a[0] + along * (b[0] - a[0])), y - (a[1] + along * (b[1] - a[1])))
