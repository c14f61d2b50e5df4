"""Where the rover may be: the one place where obstacles, keep-out zones and unseen ground become forbidden ground.

Invariants: a path lies only where a disc of the rover's radius plus MARGIN touches nothing blocked, where blocked means
an obstacle (thermal, sonar or known beforehand), a keep-out zone, ground that no frame has shown, or ground outside the
area. The ground under
the rover at the launch counts as shown: the operator surveyed it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.mission.area_masks import entered
from rover.mission.config import Area, Launch
from rover.mission.keepout import MINE_RADIUS_M, Zone
from rover.planning.fields import GridField
from rover.vehicle import Vehicle

Mask = NDArray[np.bool_]

# What the map may be wrong by: localization (usually under 1 cm) and a cell.
MARGIN = 0.025

# What is found to stand is wider than what is seen of it: the rim of a tuft is a few blades, metres.
RIM = 0.02

# What a wheel stays away from a zone beyond MARGIN: a zone may be drawn beside a path that is driven already, where
# MARGIN less CHECK_TOLERANCE and a cell's rounding would not cover what localization is off by at its worst (0.016 m).
ZONE_MARGIN = 0.02

# A path already driven on is given up only when it comes this much nearer than it was planned: a cell's rounding
# must not stop the rover.
CHECK_TOLERANCE = 0.015


@dataclass(frozen=True, eq=False)
class FreeSpace:
    """The map for one decision. Rasters are (rows, columns) with row 0 at y = 0.

    blocked: cells that nothing of the rover may touch; free: cells where its centre may be; occluders: cells that
    hide what lies behind them from the camera.
    """

    blocked: Mask
    free: Mask
    occluders: Mask
    resolution: float
    radius: float

    def field(self) -> GridField:
        """The same for the planner, which inflates by `radius` itself."""
        return GridField(self.blocked, self.resolution)

    def is_clear(self, path: NDArray[np.float64]) -> bool:
        """True when the rover can still sweep along the polyline (N, 2), metres."""
        field = self.field()
        radius = self.radius - CHECK_TOLERANCE
        points = [(float(x), float(y)) for x, y in path]
        return all(field.segment_clear(a, b, radius) for a, b in pairwise(points))


def free_space(
    occupied: Mask, seen: Mask, resolution: float, zones: Iterable[Zone], area: Area, launch: Launch, vehicle: Vehicle
) -> FreeSpace:
    """Puts together what forbids ground."""
    radius = vehicle.radius
    shown = seen | disc_mask(seen.shape, resolution, launch.pose.x, launch.pose.y, launch.surveyed_radius)
    solid = occupied.copy()
    for x, y, r in area.obstacles:
        solid |= disc_mask(seen.shape, resolution, x, y, r)
    rim = np.ones((2 * round(RIM / resolution) + 1,) * 2, np.uint8)
    blocked = solid | cv2.dilate(occupied.astype(np.uint8), rim).astype(bool) | ~shown
    blocked |= ~entered(area, launch, seen.shape, resolution)
    for zone in zones:
        # Wheels stay out of a zone; the hull, which carries nothing, may reach over its rim but not over the mine.
        core = max(zone.radius + ZONE_MARGIN - (radius - vehicle.wheel_reach), MINE_RADIUS_M)
        blocked |= disc_mask(seen.shape, resolution, zone.x, zone.y, core)
    return FreeSpace(
        blocked=blocked,
        free=_erode(blocked, resolution, radius + MARGIN),
        occluders=solid,
        resolution=resolution,
        radius=radius + MARGIN,
    )


def keep_off(space: FreeSpace, discs: NDArray[np.float64]) -> FreeSpace:
    """The same with more forbidden ground: discs (N, 3) of x, y and radius, metres, that hide nothing."""
    if not len(discs):
        return space
    blocked, size = space.blocked.copy(), space.resolution
    for x, y, r in discs.tolist():
        top, left = max(0, int((y - r) / size)), max(0, int((x - r) / size))
        patch = blocked[top : int((y + r) / size) + 1, left : int((x + r) / size) + 1]
        patch |= disc_mask((patch.shape[0], patch.shape[1]), size, x - left * size, y - top * size, r)
    return replace(space, blocked=blocked, free=_erode(blocked, space.resolution, space.radius))


def disc_mask(shape: tuple[int, int], resolution: float, x: float, y: float, radius: float) -> Mask:
    """Cells whose centre lies within `radius` of a point, metres."""
    rows, columns = shape
    dy = (np.arange(rows) + 0.5) * resolution - y
    dx = (np.arange(columns) + 0.5) * resolution - x
    return dx[None, :] ** 2 + dy[:, None] ** 2 <= radius**2


def _erode(blocked: Mask, resolution: float, radius: float) -> Mask:
    """Cells further than `radius` from anything blocked and from the border."""
    open_ground = np.zeros((blocked.shape[0] + 2, blocked.shape[1] + 2), np.uint8)
    open_ground[1:-1, 1:-1] = ~blocked
    distance = cv2.distanceTransform(open_ground, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)[1:-1, 1:-1]
    # The nearest corner of a blocked cell lies at most half a diagonal before its centre.
    return (distance - math.sqrt(0.5)) * resolution >= radius
