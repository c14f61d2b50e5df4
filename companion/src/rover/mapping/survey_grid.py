"""The map of the area: seen ground, occupied ground by camera and by sonar, and the temperature mosaic.

Occupancy is kept as log-odds, one layer per sensor, because the two err in different ways: the camera knows well
where a thing begins and takes a warm mine for no obstacle; the sonar knows that something stands there, but not where
in its cone. A cell is occupied when either layer says so. Row 0 lies at y = 0, column 0 at x = 0 of map.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.capture.frame import Frame
from rover.geometry import Pose2
from rover.mapping.camera_view import CameraView, view_polygon
from rover.mapping.shadow import obstacle_cover
from rover.mapping.sonar_cone import cone_update
from rover.mapping.spot import ClassifiedSpot
from rover.mapping.thermal_anomaly import anomalies
from rover.vehicle import SonarMount
from rover.vision.camera.model import CameraModel

# Log-odds of one frame, their limits, and from where on a cell counts as occupied.
THERMAL_HIT = 0.7
THERMAL_FREE = -0.6
LIMITS = (-2.0, 2.4)
OCCUPIED = 1.2
# What is narrower than three cells is a pebble or an edge, not an obstacle.
SMALLEST = np.ones((3, 3), np.uint8)
# An echo within three cells of an obstacle that the camera shows is the echo of that obstacle.
ECHO_SLACK = np.ones((7, 7), np.uint8)
# A frame that shows plain ground takes this from the sonar layer, where no close echo speaks against it.
SONAR_FREED = -0.35
# Echoes nearer than this, metres, outweigh the camera once PERSISTENT of them have come.
CLOSE_ECHO = 0.40
PERSISTENT = 3
# A pose less certain than this, metres, still shows the ground but maps obstacles with less weight.
SURE_POSE = 0.03
# What is learned, by the names that it has in files.
LAYERS = {
    "seen": "seen",
    "thermal": "thermal",
    "sonar": "sonar",
    "temperature": "temperature",
    "temperature_count": "_count",
    "close_echoes": "_close",
}
# Frames after which the mosaic forgets the first ones.
MOSAIC_MEMORY = 50


class SurveyGrid:
    """Rasters (rows, columns) over an area of width x height metres from map's origin."""

    def __init__(self, width: float, height: float, resolution: float = 0.02) -> None:
        self.resolution = resolution
        self.shape = (int(np.ceil(height / resolution - 1e-9)), int(np.ceil(width / resolution - 1e-9)))
        self.seen: NDArray[np.bool_] = np.zeros(self.shape, bool)
        self.thermal: NDArray[np.float32] = np.zeros(self.shape, np.float32)
        self.sonar: NDArray[np.float32] = np.zeros(self.shape, np.float32)
        self.temperature: NDArray[np.float32] = np.full(self.shape, np.nan, np.float32)
        self._count = np.zeros(self.shape, np.uint8)
        self._close = np.zeros(self.shape, np.uint8)
        self._near_obstacle: NDArray[np.bool_] = np.zeros(self.shape, bool)
        self._view: CameraView | None = None

    def layers(self) -> dict[str, NDArray[Any]]:
        """All that has been learned, by name; rasters (rows, columns)."""
        return {name: getattr(self, attribute) for name, attribute in LAYERS.items()}

    def restore(self, layers: Mapping[str, NDArray[Any]]) -> None:
        """Takes over what a grid of the same area had learned. Raises ValueError when it does not fit."""
        for name, attribute in LAYERS.items():
            layer = getattr(self, attribute)
            given = layers.get(name)
            if given is None or given.shape != layer.shape or given.dtype != layer.dtype:
                raise ValueError(f"layer {name} does not fit")
            layer[:] = given
        self._near_obstacle = cv2.dilate(self._thermal_obstacles(), ECHO_SLACK).astype(bool)

    @property
    def occupied(self) -> NDArray[np.bool_]:
        """Cells where the camera or the sonar says that something stands."""
        return self._thermal_obstacles().astype(bool) | (self.sonar > OCCUPIED)

    def _thermal_obstacles(self) -> NDArray[np.uint8]:
        strong = (self.thermal > OCCUPIED).astype(np.uint8)
        return np.asarray(cv2.morphologyEx(strong, cv2.MORPH_OPEN, SMALLEST), np.uint8)

    def view_polygon(self, camera: CameraModel) -> NDArray[np.float64]:
        """Convex outline (N, 2) in base_link of what `integrate_frame` marks as seen on open ground."""
        return view_polygon(camera)

    def integrate_frame(
        self, frame: Frame, camera: CameraModel, pose: Pose2, sigma: float, detections: Sequence[ClassifiedSpot]
    ) -> None:
        """One frame from `pose`; `sigma`: 1σ of the position in metres; detections of this frame."""
        if self._view is None or self._view.camera is not camera:
            self._view = CameraView(camera, 0.75 * self.resolution)
        view = self._view
        # The stub does not know that a map of two channels needs no second map.
        taken = cv2.remap(frame.kelvin(), view.maps, None, cv2.INTER_LINEAR)  # type: ignore[call-overload]
        kelvin: NDArray[np.float32] = taken[:, 0]
        columns, rows = np.floor(pose.transform(view.points.astype(np.float64)) / self.resolution).astype(np.intp).T
        inside = (rows >= 0) & (columns >= 0) & (rows < self.shape[0]) & (columns < self.shape[1])
        if not inside.any():
            return
        cover = obstacle_cover(view, detections)
        strong, weak = anomalies(kelvin)
        solid = (cover.obstacle & (weak | cover.core)) | (strong & ~cover.explained & ~cover.hidden)
        shown = ~cover.hidden & ~cover.obstacle & ~solid
        flat = rows * self.shape[1] + columns
        # Several points fall into a cell: the cell is what any of its points is.
        cells_shown = _cells(flat[inside & shown], self.shape)
        cells_hit = _cells(flat[inside & solid], self.shape)
        free = cells_shown & ~cells_hit
        self.seen |= free
        weight = np.float32(1.0 if sigma <= SURE_POSE else SURE_POSE / sigma)
        self.thermal[cells_hit] += THERMAL_HIT * weight
        self.thermal[free] += THERMAL_FREE * weight
        np.clip(self.thermal, *LIMITS, out=self.thermal)
        self.sonar[free & (self._close < PERSISTENT) & (self.sonar > 0.0)] += SONAR_FREED * weight
        self._add_temperature(flat[inside & shown], kelvin[inside & shown])
        self._near_obstacle = cv2.dilate(self._thermal_obstacles(), ECHO_SLACK).astype(bool)

    def _add_temperature(self, flat: NDArray[np.intp], kelvin: NDArray[np.float32]) -> None:
        size = self.shape[0] * self.shape[1]
        number = np.bincount(flat, minlength=size)
        touched = np.nonzero(number)[0]
        mean = np.bincount(flat, kelvin, minlength=size)[touched] / number[touched]
        count = np.minimum(self._count.flat[touched] + 1, MOSAIC_MEMORY).astype(np.uint8)
        before = np.nan_to_num(self.temperature.flat[touched])
        self.temperature.flat[touched] = before + (mean - before) / count
        self._count.flat[touched] = count

    def integrate_sonar(self, pose: Pose2, mount: SonarMount, range_m: float | None) -> None:
        """One ping from `pose`; range_m in metres, None when no echo came back."""
        update = cone_update(self.shape, self.resolution, pose, mount, range_m, CLOSE_ECHO)
        if update is None:
            return
        at = update.rows, update.columns
        # Where the camera shows an obstacle in the arc, the echo came from there and says nothing of the rest.
        near, hit = self._near_obstacle[at], update.change > 0.0
        change = np.where(hit & ~near, 0.0, update.change) if (near & hit).any() else update.change
        self.sonar[at] = np.clip(self.sonar[at] + change, *LIMITS)
        close = self._close[at]
        self._close[at] = np.where(
            update.near & (change > 0.4),
            np.minimum(close + 1, 2 * PERSISTENT),
            np.where(change < 0.0, np.maximum(close, 1) - 1, close),
        )


def _cells(flat: NDArray[np.intp], shape: tuple[int, int]) -> NDArray[np.bool_]:
    """Mask (rows, columns) of the cells with these flat indices."""
    mask = np.zeros(shape, bool)
    mask.flat[flat] = True
    return mask
