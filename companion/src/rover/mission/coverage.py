"""Which ground of the area is still to be looked at, and which stayed hidden however the rover looked."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rover.mapping.survey_grid import SurveyGrid
from rover.mission.config import Area, Launch
from rover.mission.freespace import Mask, disc_mask

# Viewpoints that should have shown a cell, after which it counts as hidden.
MAX_LOOKS = 2


class Coverage:
    """Masks of the area's cells, (rows, columns), over the survey's grid as it is now."""

    def __init__(self, grid: SurveyGrid, area: Area, launch: Launch) -> None:
        self._grid = grid
        self._launch = launch
        self._known = area.obstacles
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
        unshown: Mask = ~grid.seen & ~grid.occupied
        for x, y, r in self._known:
            unshown &= ~disc_mask(grid.shape, grid.resolution, x, y, r)
        return unshown & ~disc_mask(grid.shape, grid.resolution, launch.pose.x, launch.pose.y, launch.surveyed_radius)
