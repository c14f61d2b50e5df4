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

HIT, FREE = 0.7, -0.6
LIMITS = (-2.0, 2.4)
OCCUPIED = 0.5


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
        return self.log_odds > OCCUPIED

    def integrate(self, standing_out: NDArray[np.bool_], camera: CameraModel, pose: Pose2) -> None:
        """One binary picture (height, width) of `camera`, taken from `pose`. Raises BadInput for another size."""
        if standing_out.shape != (camera.height, camera.width):
            rows, columns = standing_out.shape
            raise BadInput(
                f"picture of {columns}x{rows} pixels, but camera {camera.name} has {camera.width}x{camera.height}"
            )
        if self._view is None or self._view.camera is not camera:
            self._view = CameraView(camera, 0.75 * self.resolution)
        view = self._view
        # The stub does not know that a map of two channels needs no second map.
        shown = cv2.remap(standing_out.astype(np.uint8), view.maps, None, cv2.INTER_NEAREST)  # type: ignore[call-overload]
        hit: NDArray[np.bool_] = shown[:, 0] > 0
        columns, rows = np.floor(pose.transform(view.points.astype(np.float64)) / self.resolution).astype(np.intp).T
        inside = (rows >= 0) & (columns >= 0) & (rows < self.shape[0]) & (columns < self.shape[1])
        cells_hit, cells_seen = np.zeros(self.shape, bool), np.zeros(self.shape, bool)
        cells_seen[rows[inside], columns[inside]] = True
        cells_hit[rows[inside & hit], columns[inside & hit]] = True
        self.log_odds[cells_hit] += HIT
        self.log_odds[cells_seen & ~cells_hit] += FREE
        np.clip(self.log_odds, *LIMITS, out=self.log_odds)
        self.seen |= cells_seen
