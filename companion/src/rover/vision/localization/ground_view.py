"""The picture as seen from straight above: one scale and no perspective, so that features match from every side.

A camera that looks down at 52° sees the same patch of ground 2.5 times smaller at its upper edge than at its lower
one, and squeezed. Laid onto the ground first, two views differ only by a turn and a shift, which steered BRIEF
follows; what stands above the ground is displaced away from the mast and is left to the outlier tests.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.vision.camera.model import CameraModel


@dataclass(frozen=True)
class GroundView:
    """A raster on the ground in front of the rover: rows run towards it, columns to its right.

    resolution: metres per pixel. far: ground further ahead than this (metres) is left out.
    """

    camera: CameraModel
    resolution: float = 0.008
    far: float = 1.4

    @cached_property
    def bounds(self) -> tuple[float, float, float, float]:
        """(x_min, x_max, y_min, y_max) in base_link of the ground that the camera sees, up to `far`."""
        seen = self.camera.ground_lookup.reshape(-1, 2).astype(np.float64)
        seen = seen[np.isfinite(seen).all(axis=1)]
        seen = seen[seen[:, 0] <= self.far]
        if len(seen) == 0:
            return 0.0, self.resolution, 0.0, self.resolution
        (x0, y0), (x1, y1) = seen.min(axis=0), seen.max(axis=0)
        return float(x0), float(x1), float(y0), float(y1)

    @cached_property
    def size(self) -> tuple[int, int]:
        """(width, height) in pixels."""
        x0, x1, y0, y1 = self.bounds
        return int((y1 - y0) / self.resolution) + 1, int((x1 - x0) / self.resolution) + 1

    def to_base(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Pixels (N, 2) of this view to base_link (N, 2)."""
        _, x1, _, y1 = self.bounds
        return np.column_stack((x1 - points[:, 1] * self.resolution, y1 - points[:, 0] * self.resolution))

    def from_base(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """base_link (N, 2) to pixels (N, 2) of this view."""
        _, x1, _, y1 = self.bounds
        return np.column_stack(((y1 - points[:, 1]) / self.resolution, (x1 - points[:, 0]) / self.resolution))

    @cached_property
    def _maps(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        width, height = self.size
        v, u = np.mgrid[0:height, 0:width]
        base = self.to_base(np.column_stack((u.ravel(), v.ravel())).astype(np.float64))
        pixels = self.camera.ground_to_pixel(base).astype(np.float32)
        return pixels[:, 0].reshape(height, width), pixels[:, 1].reshape(height, width)

    @cached_property
    def mask(self) -> NDArray[np.uint8]:
        """255 where the ground is in the picture, else 0; (height, width)."""
        width, height = self.size
        u, v = self._maps
        uv = np.column_stack((u.ravel(), v.ravel())).astype(np.float64)
        return (self.camera.inside(uv, 1.0).reshape(height, width) * 255).astype(np.uint8)

    def look(self, image: NDArray[np.float32]) -> NDArray[np.float32]:
        """A picture of the camera (H, W) laid onto the ground; outside of it the edge is repeated."""
        u, v = self._maps
        return np.asarray(cv2.remap(image, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE), np.float32)
