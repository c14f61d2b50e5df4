"""An occupancy grid from binary pictures alone, thermal or visible: the two grids of the paper's figure 5.

The rover's own map (`survey_grid`) asks the classifier what an anomaly is. This one does not: it shows what a sensor
by itself says about the ground, in log-odds over as many frames as there are.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.errors import BadInput
from rover.geometry import Pose2
from rover.mapping.camera_view import CameraView
from rover.vision.camera.model import CameraModel

# Log-odds that one frame adds where something stands out and where nothing does, their limits, and from where on a
# cell counts as occupied.
HIT_LOG_ODDS, FREE_LOG_ODDS = 0.7, -0.6
LOG_ODDS_LIMITS = (-2.0, 2.4)
OCCUPIED_LOG_ODDS = 0.5
# Points of a camera's view on each side of a cell: none may be stepped over.
VIEW_SPACING_CELLS = 0.75


class PictureGrid:
    """Log-odds (rows, columns) over an area of width x height metres from map's origin; row 0 at y = 0."""

    def __init__(self, width: float, height: float, resolution: float = 0.02) -> None:
        self.resolution = resolution
        self.shape = (int(np.ceil(height / resolution - 1e-9)), int(np.ceil(width / resolution - 1e-9)))
        self.log_odds: NDArray[np.float32] = np.zeros(self.shape, np.float32)
        self.seen: NDArray[np.bool_] = np.zeros(self.shape, bool)
        self._view: CameraView | None = None

    @property
    def occupied(self) -> NDArray[np.bool_]:
        """Cells that are more likely occupied than not, by a margin."""
        return self.log_odds > OCCUPIED_LOG_ODDS

    @property
    def free(self) -> NDArray[np.bool_]:
        """Cells that were seen and are not occupied."""
        return self.seen & ~self.occupied

    def integrate(self, standing_out: NDArray[np.bool_], camera: CameraModel, pose: Pose2) -> None:
        """One binary picture (height, width) of `camera`, taken from `pose`. Raises BadInput for another size."""
        if standing_out.shape != (camera.height, camera.width):
            rows, columns = standing_out.shape
            raise BadInput(
                f"picture of {columns}x{rows} pixels, but camera {camera.name} has {camera.width}x{camera.height}"
            )
        if self._view is None or self._view.camera is not camera:
            self._view = CameraView(camera, VIEW_SPACING_CELLS * self.resolution)
        view = self._view
        # The stub does not know that a map of two channels needs no second map.
        shown = cv2.remap(standing_out.astype(np.uint8), view.maps, None, cv2.INTER_NEAREST)  # type: ignore[call-overload]
        hit: NDArray[np.bool_] = shown[:, 0] > 0
        columns, rows = np.floor(pose.transform(view.points.astype(np.float64)) / self.resolution).astype(np.intp).T
        inside = (rows >= 0) & (columns >= 0) & (rows < self.shape[0]) & (columns < self.shape[1])
        cells_hit, cells_seen = np.zeros(self.shape, bool), np.zeros(self.shape, bool)
        cells_seen[rows[inside], columns[inside]] = True
        cells_hit[rows[inside & hit], columns[inside & hit]] = True
        self._update(cells_hit, cells_seen)

    def integrate_from_above(self, standing_out: NDArray[np.bool_]) -> None:
        """One binary picture taken from straight above, a pixel a cell, its lower edge at y = 0. Raises BadInput."""
        if standing_out.shape != self.shape:
            size, wanted = (f"{shape[1]}x{shape[0]}" for shape in (standing_out.shape, self.shape))
            raise BadInput(f"picture of {size} pixels, the first one has {wanted}: give pictures of one size")
        self._update(np.flipud(standing_out), np.ones(self.shape, bool))

    def _update(self, hit: NDArray[np.bool_], seen: NDArray[np.bool_]) -> None:
        self.log_odds[hit] += HIT_LOG_ODDS
        self.log_odds[seen & ~hit] += FREE_LOG_ODDS
        np.clip(self.log_odds, *LOG_ODDS_LIMITS, out=self.log_odds)
        self.seen |= seen
