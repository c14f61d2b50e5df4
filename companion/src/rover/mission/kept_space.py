"""Free space that is kept: after a frame only the cells around what has changed are worked out anew.

The same cells as `free_space` of the whole map gives, at a cost that does not depend on the size of the field.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.mapping.rectangle import Rectangle
from rover.mapping.survey_grid import SurveyGrid
from rover.mission.area_masks import entered
from rover.mission.config import Area, Launch
from rover.mission.freespace import (
    MARGIN,
    FreeSpace,
    Mask,
    core_radius,
    eroded,
    forbidden,
    rectangle_of,
)
from rover.mission.keepout import Zone
from rover.vehicle import Vehicle

Disc = tuple[float, float, float]

# Standard deviations of the place in map by which the rover stays inside the border, less what it keeps anyway.
BORDER_SIGMAS = 2.0


class KeptSpace:
    """Of one survey. The rasters that `now` hands out change with its next call."""

    def __init__(self, grid: SurveyGrid, launch: Launch, vehicle: Vehicle) -> None:
        self._grid, self._launch, self._vehicle = grid, launch, vehicle
        radius = self.radius = vehicle.radius + MARGIN
        self._reach = math.ceil(radius / grid.resolution) + 1
        self._space = FreeSpace(
            np.ones(grid.shape, bool),
            np.zeros(grid.shape, bool),
            np.zeros(grid.shape, bool),
            grid.resolution,
            radius,
            grid.area,
        )
        self._discs: set[Disc] | None = None
        # Cells from the border that the rover does not enter, and how far inside it each cell lies.
        self._border = 0
        self._inside: NDArray[np.float32] | None = None

    def now(self, zones: Iterable[Zone], area: Area, sigma: float = 0.0) -> FreeSpace:
        """As `free_space` of the map, the zones and the obstacles of `area` as they are now.

        sigma: 1σ in metres of the rover's place in map. The border lies in map and nowhere on the ground: who does not
        know the way to the launch well does not know well where it is. What has been seen of it from within is enough.
        """
        zones = list(zones)
        border = math.ceil(max(BORDER_SIGMAS * sigma - MARGIN, 0.0) / self._grid.resolution)
        # One cell less is not worth the work: it would be taken back and forth.
        if border > self._border or border < self._border - 1:
            self._border, self._discs = border, None
        discs = {(zone.x, zone.y, core_radius(zone.radius, self._vehicle)) for zone in zones} | set(area.obstacles)
        changed = self._grid.changes()
        if self._discs is None:
            changed = [self._grid.area]
        else:
            changed += [rectangle_of(self._grid.resolution, *disc) for disc in discs ^ self._discs]
        self._discs = discs
        for where in _gathered([where.within(self._grid.area) for where in changed]):
            self._update(where, zones, area)
        return self._space

    def _update(self, where: Rectangle, zones: list[Zone], area: Area) -> None:
        grid, space = self._grid, self._space
        at = where.slices(grid.area)
        may_enter = self._may_enter(where, area)
        space.occluders[at], space.blocked[at] = forbidden(
            where,
            grid.occupied[at],
            grid.seen[at],
            may_enter,
            grid.resolution,
            zones,
            area.obstacles,
            self._launch,
            self._vehicle,
        )
        reached = where.grown(self._reach).within(grid.area)
        around = reached.grown(self._reach).within(grid.area)
        free = eroded(space.blocked[around.slices(grid.area)], grid.resolution, space.radius)
        space.free[reached.slices(grid.area)] = free[reached.slices(around)]

    def _may_enter(self, where: Rectangle, area: Area) -> Mask:
        grid = self._grid
        if self._inside is None:
            mask = entered(replace(area, obstacles=()), self._launch, grid.shape, grid.resolution)
            padded = np.pad(mask, 1).astype(np.uint8)
            distance = cv2.distanceTransform(padded, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
            self._inside = np.asarray(distance[1:-1, 1:-1], np.float32)
        may_enter: Mask = self._inside[where.slices(grid.area)] > self._border
        return may_enter


def _gathered(rectangles: Iterable[Rectangle]) -> list[Rectangle]:
    """Rectangles that hold all cells of these; those that overlap are joined."""
    gathered: list[Rectangle] = []
    for where in rectangles:
        if where.empty:
            continue
        joined = where
        apart = []
        for other in gathered:
            if joined.within(other).empty:
                apart.append(other)
            else:
                joined = joined.joined(other)
        gathered = [*apart, joined]
    return gathered
