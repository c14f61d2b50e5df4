"""What one echo of an ultrasonic sensor says about the ground: an arc that may be occupied, a cone that is not.

A cone of 30° is 52 cm wide at 1 m, and the echo does not say from where in it: far echoes and cells off the axis
weigh little, and echoes beyond MAX_HIT only tell that the ground before them is free.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rover.geometry import Pose2
from rover.mapping.rectangle import Rectangle
from rover.vehicle import SonarMount

MAX_HIT = 0.80
# Free ground is believed this far, even when no echo comes at all: soft things answer weakly.
MAX_FREE = 0.80
ARC_DEPTH = 0.05
# An echo this near is believed fully; at MAX_HIT it has MIN_WEIGHT.
SURE_RANGE = 0.30
MIN_WEIGHT = 0.15
HIT = 1.1
FREE = -0.25


@dataclass(frozen=True, eq=False)
class ConeUpdate:
    """Cells and what they change by: rows, columns (N,), change (N,) in log-odds. near: close hits, (N,) bool."""

    rows: NDArray[np.intp]
    columns: NDArray[np.intp]
    change: NDArray[np.float32]
    near: NDArray[np.bool_]


def cone_update(
    limits: Rectangle, resolution: float, pose: Pose2, mount: SonarMount, range_m: float | None, near: float
) -> ConeUpdate | None:
    """The update of the cells within `limits` by one ping; range_m None: no echo. None when no cell is touched.

    `near`: echoes below this range (m) are marked as close.
    """
    sensor = pose.compose(Pose2(mount.x, mount.y, mount.yaw))
    reach = min(MAX_FREE, MAX_HIT if range_m is None else range_m + ARC_DEPTH) + resolution
    low = np.floor((np.array([sensor.x, sensor.y]) - reach) / resolution).astype(int)
    high = np.ceil((np.array([sensor.x, sensor.y]) + reach) / resolution).astype(int) + 1
    low, high = np.maximum(low, (limits.left, limits.top)), np.minimum(high, (limits.right, limits.bottom))
    if (low >= high).any():
        return None
    x = (np.arange(low[0], high[0]) + 0.5) * resolution - sensor.x
    y = (np.arange(low[1], high[1]) + 0.5) * resolution - sensor.y
    c, s = np.cos(sensor.heading), np.sin(sensor.heading)
    along = c * x[None, :] + s * y[:, None]
    across = c * y[:, None] - s * x[None, :]
    distance = np.hypot(along, across)
    angle = np.abs(np.arctan2(across, along)) / mount.half_angle
    inside = angle <= 1.0
    off_axis = np.exp(-0.5 * (angle / 0.45) ** 2)
    end = MAX_FREE if range_m is None else min(range_m - 0.5 * ARC_DEPTH, MAX_FREE)
    change = np.where(inside & (distance < end), FREE * off_axis, 0.0)
    arc = np.zeros_like(inside)
    if range_m is not None and range_m <= MAX_HIT:
        arc = inside & (distance >= range_m - 0.3 * ARC_DEPTH) & (distance <= range_m + 0.7 * ARC_DEPTH)
        share = np.clip((range_m - SURE_RANGE) / (MAX_HIT - SURE_RANGE), 0.0, 1.0)
        weight = 1.0 - (1.0 - MIN_WEIGHT) * share
        change = np.where(arc, HIT * weight * off_axis, change)
    rows, columns = np.nonzero(change)
    if not len(rows):
        return None
    close = arc[rows, columns] & (range_m is not None and range_m < near)
    return ConeUpdate(rows + low[1], columns + low[0], change[rows, columns].astype(np.float32), close)
