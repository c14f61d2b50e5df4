"""Where to stand to inspect a suspected mine: at a stand-off, facing it, in the camera's view."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from rover.geometry import Pose2

Mask = NDArray[np.bool_]

# What lies nearer than this to the suspected mine belongs to it and hides nothing.
TARGET_RADIUS_M = 0.08

# Stand-offs that are tried, nearest first, metres: within the ground that the camera sees, 0.16 to 1.1 m ahead.
STANDOFFS = (0.35, 0.40, 0.45, 0.50, 0.60, 0.70, 0.80, 0.90)


def inspection_poses(
    place: tuple[float, float],
    free: Mask,
    resolution: float,
    distance: NDArray[np.float32],
    *,
    origin: tuple[float, float] = (0.0, 0.0),
    standoffs: Sequence[float] = STANDOFFS,
    bearings: int = 36,
    occluders: Mask | None = None,
) -> list[Pose2]:
    """Reachable poses around `place` that face it, nearest in travel first; empty when there is none.

    `free` (rows, columns): where the robot's centre may be; `distance`: from `distance_field`, metres;
    `occluders`: cells through which the camera can't see. The stand-offs lie inside the ground that the camera
    sees, 0.16 to 1.1 m ahead. Of each bearing only the nearest possible stand-off is offered.
    """
    rows, columns = free.shape
    found: list[tuple[float, int, Pose2]] = []
    for number in range(bearings):
        bearing = 2.0 * math.pi * number / bearings
        for standoff in standoffs:
            x = place[0] + standoff * math.cos(bearing)
            y = place[1] + standoff * math.sin(bearing)
            column = math.floor((x - origin[0]) / resolution)
            row = math.floor((y - origin[1]) / resolution)
            if not (0 <= column < columns and 0 <= row < rows and free[row, column]):
                continue
            travel = float(distance[row, column])
            if not math.isfinite(travel):
                continue
            if occluders is not None and _hidden(place, (x, y), occluders, resolution, origin):
                continue
            heading = math.atan2(place[1] - y, place[0] - x)
            found.append((travel, number, Pose2(x, y, heading)))
            break
    found.sort(key=lambda entry: entry[:2])
    return [pose for _, _, pose in found]


def _hidden(
    place: tuple[float, float],
    eye: tuple[float, float],
    occluders: Mask,
    resolution: float,
    origin: tuple[float, float],
) -> bool:
    """True when an occluding cell lies between; the last TARGET_RADIUS_M are the suspected mine itself."""
    length = math.dist(place, eye)
    count = max(2, math.ceil(2.0 * length / resolution))
    along = np.linspace(0.0, max(0.0, 1.0 - TARGET_RADIUS_M / length) if length > 0.0 else 0.0, count)
    column = np.floor((eye[0] + along * (place[0] - eye[0]) - origin[0]) / resolution).astype(int)
    row = np.floor((eye[1] + along * (place[1] - eye[1]) - origin[1]) / resolution).astype(int)
    inside = (column >= 0) & (row >= 0) & (column < occluders.shape[1]) & (row < occluders.shape[0])
    return bool(occluders[row[inside], column[inside]].any())
