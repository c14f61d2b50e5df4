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

from rover.mapping.rectangle import Rectangle
from rover.mission.area_masks import entered
from rover.mission.config import Area, Launch
from rover.mission.keepout import MINE_RADIUS_M, Zone
from rover.planning.fields import GridField
from rover.vehicle import Vehicle

Mask = NDArray[np.bool_]

# What the map may be wrong by: localization (usually under 1 cm) and a cell.
MARGIN = 0.025

# What a wheel stays away from a zone beyond MARGIN: a zone may be drawn beside a path that is driven already, where
# MARGIN less CHECK_TOLERANCE and a cell's rounding would not cover what localization is off by at its worst (0.016 m).
ZONE_MARGIN = 0.02

# Around a path, what can matter to a rover on it, metres: its radius, and room to be beside the path.
NEAR = 0.6

# A path already driven on is given up only when it comes this much nearer than it was planned: a cell's rounding
# must not stop the rover.
CHECK_TOLERANCE = 0.015


@dataclass(frozen=True, eq=False)
class FreeSpace:
    """The map for one decision, or a rectangle of it. Rasters are (rows, columns), the first row at the least y.

    blocked: cells that nothing of the rover may touch; free: cells where its centre may be; occluders: cells that
    hide what lies behind them from the camera. where: which cells of the map they are.
    """

    blocked: Mask
    free: Mask
    occluders: Mask
    resolution: float
    radius: float
    where: Rectangle

    @property
    def origin(self) -> tuple[float, float]:
        """x, y in map of the rasters' corner, metres."""
        return self.where.left * self.resolution, self.where.top * self.resolution

    def field(self) -> GridField:
        """The same for the planner, which inflates by `radius` itself."""
        return GridField(self.blocked, self.resolution, self.origin)

    def is_clear(self, path: NDArray[np.float64]) -> bool:
        """True when the rover can still sweep along the polyline (N, 2), metres."""
        field = self.field()
        radius = self.radius - CHECK_TOLERANCE
        points = [(float(x), float(y)) for x, y in path]
        return all(field.segment_clear(a, b, radius) for a, b in pairwise(points))

    def around(self, points: NDArray[np.float64], reach: float = NEAR) -> FreeSpace:
        """The rectangle of it within `reach` metres of these points (N, 2); its border is none to what lies within."""
        low, high = points.min(axis=0) - reach, points.max(axis=0) + reach
        left, top = np.floor(low / self.resolution).astype(int).tolist()
        right, bottom = np.ceil(high / self.resolution).astype(int).tolist()
        where = Rectangle(top, left, bottom, right).within(self.where)
        if where.empty or where == self.where:
            return self
        at = where.slices(self.where)
        return replace(self, blocked=self.blocked[at], free=self.free[at], occluders=self.occluders[at], where=where)


def free_space(
    occupied: Mask, seen: Mask, resolution: float, zones: Iterable[Zone], area: Area, launch: Launch, vehicle: Vehicle
) -> FreeSpace:
    """Puts together what forbids ground, all over the map."""
    where = Rectangle(0, 0, *seen.shape)
    may_enter = entered(area, launch, seen.shape, resolution)
    solid, blocked = forbidden(where, occupied, seen, may_enter, resolution, zones, area.obstacles, launch, vehicle)
    radius = vehicle.radius + MARGIN
    return FreeSpace(blocked, eroded(blocked, resolution, radius), solid, resolution, radius, where)


def forbidden(
    where: Rectangle,
    occupied: Mask,
    seen: Mask,
    may_enter: Mask,
    resolution: float,
    zones: Iterable[Zone],
    obstacles: Iterable[tuple[float, float, float]],
    launch: Launch,
    vehicle: Vehicle,
) -> tuple[Mask, Mask]:
    """Solid and blocked cells of a rectangle of the map; the masks are of that rectangle."""
    shown = seen | disc(where, resolution, launch.pose.x, launch.pose.y, launch.surveyed_radius)
    solid = occupied.copy()
    for x, y, r in obstacles:
        _add_disc(solid, where, resolution, x, y, r)
    blocked = solid | ~shown | ~may_enter
    for zone in zones:
        _add_disc(blocked, where, resolution, zone.x, zone.y, core_radius(zone.radius, vehicle))
    return solid, blocked


def core_radius(zone_radius: float, vehicle: Vehicle) -> float:
    """How much of a zone nothing of the rover may touch, metres.

    Wheels stay out of a zone; the hull, which carries nothing, may reach over its rim but not over the mine.
    """
    return max(zone_radius + ZONE_MARGIN - (vehicle.radius - vehicle.wheel_reach), MINE_RADIUS_M)


def keep_off(space: FreeSpace, discs: NDArray[np.float64]) -> FreeSpace:
    """The same with more forbidden ground: discs (N, 3) of x, y and radius, metres, that hide nothing."""
    if not len(discs):
        return space
    blocked = space.blocked.copy()
    for x, y, r in discs.tolist():
        _add_disc(blocked, space.where, space.resolution, x, y, r)
    return replace(space, blocked=blocked, free=eroded(blocked, space.resolution, space.radius))


def disc_mask(shape: tuple[int, int], resolution: float, x: float, y: float, radius: float) -> Mask:
    """Cells whose centre lies within `radius` of a point, metres."""
    return disc(Rectangle(0, 0, *shape), resolution, x, y, radius)


def disc(where: Rectangle, resolution: float, x: float, y: float, radius: float) -> Mask:
    """The same of a rectangle of the map."""
    across, up = where.centres(resolution)
    inside: Mask = (across - x) ** 2 + (up - y) ** 2 <= radius**2
    return inside


def rectangle_of(resolution: float, x: float, y: float, radius: float) -> Rectangle:
    """Cells that a disc can touch."""
    return Rectangle(
        math.floor((y - radius) / resolution),
        math.floor((x - radius) / resolution),
        math.ceil((y + radius) / resolution),
        math.ceil((x + radius) / resolution),
    )


def _add_disc(mask: Mask, where: Rectangle, resolution: float, x: float, y: float, radius: float) -> None:
    part = rectangle_of(resolution, x, y, radius).within(where)
    if not part.empty:
        mask[part.slices(where)] |= disc(part, resolution, x, y, radius)


def eroded(blocked: Mask, resolution: float, radius: float) -> Mask:
    """Cells further than `radius` from anything blocked and from the border."""
    open_ground = np.zeros((blocked.shape[0] + 2, blocked.shape[1] + 2), np.uint8)
    open_ground[1:-1, 1:-1] = ~blocked
    distance = cv2.distanceTransform(open_ground, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)[1:-1, 1:-1]
    # The nearest corner of a blocked cell lies at most half a diagonal before its centre.
    return (distance - math.sqrt(0.5)) * resolution >= radius
