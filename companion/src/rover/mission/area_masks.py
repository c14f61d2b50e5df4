"""Which cells of the map are to be surveyed, and which the rover may enter: the area's outline and what it leaves out.

Inside the outline the rover may go wherever it has seen the ground; what is excluded it neither surveys nor enters.
From a launch outside the outline a strip leads in, straight to the nearest point of it.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from rover.mission.config import Area, Launch
from rover.mission.outline import STRIP_M, contains, distance_to_segment, inside, nearest

Mask = NDArray[np.bool_]


@lru_cache(maxsize=8)
def wanted(area: Area, shape: tuple[int, int], resolution: float) -> Mask:
    """Cells (rows, columns) whose centres lie in the area and in nothing that it excludes."""
    x, y = _centres(shape, resolution)
    mask = contains(area.polygon, x, y) if area.polygon else np.ones(shape, bool)
    for hole in area.exclude:
        mask &= ~contains(hole, x, y)
    mask.flags.writeable = False
    return mask


@lru_cache(maxsize=8)
def entered(area: Area, launch: Launch, shape: tuple[int, int], resolution: float) -> Mask:
    """Cells that the rover may enter once it has seen them."""
    mask = wanted(area, shape, resolution)
    start = (launch.pose.x, launch.pose.y)
    if not area.polygon or inside(area.polygon, start):
        return mask
    x, y = _centres(shape, resolution)
    strip = distance_to_segment(x, y, start, nearest(area.polygon, start)) <= STRIP_M
    for hole in area.exclude:
        strip &= ~contains(hole, x, y)
    both: Mask = mask | strip
    both.flags.writeable = False
    return both


def _centres(shape: tuple[int, int], resolution: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    rows, columns = shape
    x, y = np.arange(columns, dtype=np.float64)[None, :], np.arange(rows, dtype=np.float64)[:, None]
    return (x + 0.5) * resolution, (y + 0.5) * resolution
