"""Which ground of the area is still to be looked at, and which stayed hidden however the rover looked."""

from __future__ import annotations

import math
from collections.abc import Iterable

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.geometry import Pose2
from rover.mapping.survey_grid import SurveyGrid
from rover.mission.area_masks import wanted
from rover.mission.config import Area, Launch
from rover.mission.freespace import FreeSpace, Mask, disc_mask
from rover.mission.targets import START_ESCAPE
from rover.mission.visible import visible_from

# More cells than these are counted in a coarser raster: the rover waits for the answer.
MAX_VIEW_CELLS = 100_000
# Viewpoints that should have shown a cell, after which it counts as hidden.
MAX_LOOKS = 2


class Coverage:
    """Masks of the area's cells, (rows, columns), over the survey's grid as it is now."""

    def __init__(self, grid: SurveyGrid, area: Area, launch: Launch) -> None:
        self._grid = grid
        self._launch = launch
        self._known = area.obstacles
        self.wanted = wanted(area, grid.shape, grid.resolution)
        self.looks: NDArray[np.uint8] = np.zeros(grid.shape, np.uint8)

    def restore(self, looks: NDArray[np.uint8]) -> None:
        """Takes over how often each cell was looked for. Raises ValueError when it does not fit."""
        if looks.shape != self.looks.shape:
            raise ValueError("looks do not fit")
        self.looks[:] = looks

    def look(self, in_view: Mask) -> None:
        """Notes that the rover has looked at these cells from a viewpoint."""
        self.looks[self.unshown() & in_view] += 1

    def unseen(self) -> Mask:
        """Cells that no frame has shown and that are worth looking at."""
        return self.unshown() & (self.looks < MAX_LOOKS)

    def hidden(self) -> Mask:
        """Cells that stayed unseen though the rover looked."""
        return self.unshown() & (self.looks >= MAX_LOOKS)

    def unshown(self) -> Mask:
        """Cells that are neither shown, nor under an obstacle, nor surveyed by the operator at the launch."""
        grid, launch = self._grid, self._launch
        unshown: Mask = ~grid.seen & self.ground()
        return unshown & ~disc_mask(grid.shape, grid.resolution, launch.pose.x, launch.pose.y, launch.surveyed_radius)

    def surveyed_share(self) -> float:
        """Share of the area that is shown or under an obstacle, 0 to 1, whether it could be seen or not."""
        return 1.0 - float(self.unshown().sum()) / max(int(self.wanted.sum()), 1)

    def gain_units(self, unit_m2: float) -> int:
        """Grows by one with every so many m² that were shown, or looked for in vain."""
        settled = int(self.wanted.sum()) - int(self.unseen().sum())
        return int(settled * self._grid.resolution**2 / unit_m2)

    def ground(self) -> Mask:
        """Cells of the area that no obstacle covers."""
        grid = self._grid
        ground: Mask = self.wanted & ~grid.occupied
        for x, y, r in self._known:
            ground &= ~disc_mask(grid.shape, grid.resolution, x, y, r)
        return ground

    def share(self, passable: FreeSpace, starts: Iterable[Pose2], reach: float) -> float:
        """Share shown, 0 to 1, of the ground in view of poses that could be reached: by the rover's own map.

        `passable`: the free space if all unseen ground were free, so that ground is not left out for want of having
        been seen; `starts`: where the rover can begin; `reach`: of its view, metres. Hidden ground does not count.
        """
        _, labels = cv2.connectedComponents(passable.free.astype(np.uint8), connectivity=8)
        reached = np.zeros_like(passable.free)
        rows, columns = np.nonzero(passable.free)
        for start in starts:
            away = np.hypot(
                (rows + 0.5) * passable.resolution - start.y, (columns + 0.5) * passable.resolution - start.x
            )
            if away.size and away.min() <= START_ESCAPE:
                nearest = int(np.argmin(away))
                reached |= labels == labels[rows[nearest], columns[nearest]]
        coarse = math.ceil(math.sqrt(reached.size / MAX_VIEW_CELLS))
        there = np.s_[::coarse, ::coarse]
        seen_from = visible_from(reached[there], passable.occluders[there], reach, coarse * passable.resolution)
        visible = seen_from & (self.ground() & ~self.hidden())[there]
        count = int(visible.sum())
        return float((visible & ~self.unshown()[there]).sum()) / count if count else 1.0
