"""How well a pixel's place on the ground is known, and a ground point's pixel: covariances carried through the camera.

To first order: the Jacobian of the mapping in the pixel (or point) and in the camera's parameters, by differences.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from rover.vision.camera.model import CameraModel

Points = NDArray[np.float64]
STEP = 1e-5


@dataclass(frozen=True)
class UncertainCamera:
    """A camera of whose parameters `names` (fields of CameraModel) the `covariance` (P, P) is known."""

    camera: CameraModel
    names: tuple[str, ...]
    covariance: Points

    def pixel_to_ground(self, pixels: Points, sigma_px: float) -> tuple[Points, Points]:
        """Ground points (N, 2) in base_link of pixels (N, 2) read to `sigma_px`, and their covariances (N, 2, 2).

        nan at and above the horizon, like CameraModel.pixel_to_ground (eq. 7, 11).
        """
        spread = np.broadcast_to(sigma_px**2 * np.eye(2), (len(pixels), 2, 2))
        return self._carry(lambda camera, at: camera.pixel_to_ground(at), pixels, spread)

    def ground_to_pixel(self, points: Points, covariances: Points) -> tuple[Points, Points]:
        """Pixels (N, 2) of ground points (N, 2) known to `covariances` (N, 2, 2), and theirs (N, 2, 2)."""
        return self._carry(lambda camera, at: camera.ground_to_pixel(at), points, covariances)

    def _carry(
        self, mapping: Callable[[CameraModel, Points], Points], at: Points, spread: Points
    ) -> tuple[Points, Points]:
        at = np.asarray(at, dtype=np.float64)
        by_place = np.stack(
            [
                (mapping(self.camera, at + move) - mapping(self.camera, at - move)) / (2.0 * STEP)
                for move in STEP * np.eye(2)
            ],
            axis=2,
        )
        total = by_place @ spread @ by_place.transpose(0, 2, 1)
        if self.names:
            by_camera = np.stack([self._slope(mapping, at, name) for name in self.names], axis=2)
            total = total + by_camera @ self.covariance @ by_camera.transpose(0, 2, 1)
        return mapping(self.camera, at), total

    def _slope(self, mapping: Callable[[CameraModel, Points], Points], at: Points, name: str) -> Points:
        value = getattr(self.camera, name)
        up, down = (mapping(replace(self.camera, **{name: value + step}), at) for step in (STEP, -STEP))
        return (up - down) / (2.0 * STEP)
