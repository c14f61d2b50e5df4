"""A path as it comes, made fit for driving: finite points, no legs of no length, no vertices on a straight line."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray
from rover.errors import BadInput
from rover.motion.path.clearance import ClearanceMap

Array = NDArray[np.float64]


def finite_points(path: ArrayLike) -> Array:
    """The path as (N, 2). Raises BadInput when it is no finite polyline in metres."""
    try:
        points = np.asarray(path, dtype=np.float64)
    except (TypeError, ValueError):
        raise BadInput("the path must be a list of points [x, y] in metres") from None
    if points.size == 0:
        return np.empty((0, 2))
    if points.ndim != 2 or points.shape[1] != 2:
        raise BadInput("the path must be a list of points [x, y] in metres")
    if not np.isfinite(points).all():
        raise BadInput(f"point {int(np.argmin(np.isfinite(points).all(axis=1))) + 1} of the path is not finite")
    return points


def distinct(points: Array, min_leg: float) -> Array:
    """The path without legs shorter than `min_leg` metres; its ends stay."""
    steps = np.hypot(*np.diff(points, axis=0).T)
    if len(steps) and steps.min() >= min_leg:
        return points
    kept = points[:1].tolist()
    for x, y in points[1:].tolist():
        if math.hypot(x - kept[-1][0], y - kept[-1][1]) >= min_leg:
            kept.append([x, y])
    if len(kept) > 1 and kept[-1] != points[-1].tolist():
        kept[-1] = points[-1].tolist()
    return np.array(kept).reshape(-1, 2)


def simplified(points: Array, tolerance: float, clearance: ClearanceMap | None = None) -> tuple[Array, Array]:
    """(M, 2) of the points, so that those left out lie within `tolerance` metres of the leg that passes them.

    Also the largest distance of them for each leg, (M − 1,). With `clearance` a leg that the footprint may not be swept
    along keeps all of its points. Linear in the number of points (a cone from the last point that was kept).
    """
    if len(points) < 3:
        return points, np.zeros(max(len(points) - 1, 0))
    kept = np.array(_cone(points.tolist(), max(tolerance, 1e-9)))
    if clearance is not None and len(kept) < len(points):
        skipping = np.diff(kept) > 1
        clear = clearance.swept(points[kept[:-1]], points[kept[1:]], np.zeros(len(kept) - 1))
        back = [np.arange(kept[leg] + 1, kept[leg + 1]) for leg in np.flatnonzero(skipping & ~clear)]
        if back:
            kept = np.union1d(kept, np.concatenate(back))
    left_out = np.setdiff1d(np.arange(len(points)), kept)
    leg = np.searchsorted(kept, left_out) - 1
    a, b = points[kept[leg]], points[kept[leg + 1]]
    along = b - a
    share = np.clip(((points[left_out] - a) * along).sum(axis=1) / np.maximum((along**2).sum(axis=1), 1e-18), 0.0, 1.0)
    error = np.zeros(len(kept) - 1)
    np.maximum.at(error, leg, np.hypot(*(points[left_out] - a - share[:, None] * along).T))
    return points[kept], error


def _cone(points: list[list[float]], tolerance: float) -> list[int]:
    """Numbers of the points to keep: each is the farthest that can be seen past all points between."""
    kept = [0]
    anchor, end = 0, len(points) - 1
    while anchor < end:
        ax, ay = points[anchor]
        low, high, ahead, farthest, last = -math.inf, math.inf, 0.0, 0.0, anchor + 1
        for number in range(anchor + 1, end + 1):
            dx, dy = points[number][0] - ax, points[number][1] - ay
            distance = math.hypot(dx, dy)
            if distance < farthest - tolerance:
                break
            if distance <= tolerance:
                if farthest == 0.0:
                    last = number
                continue
            angle = math.atan2(dy, dx)
            if farthest == 0.0:
                ahead = angle
            off = (angle - ahead + math.pi) % (2.0 * math.pi) - math.pi
            if not low <= off <= high:
                break
            width = math.asin(tolerance / distance)
            low, high = max(low, off - width), min(high, off + width)
            if distance > farthest:
                farthest, last = distance, number
        kept.append(last)
        anchor = last
    return kept
