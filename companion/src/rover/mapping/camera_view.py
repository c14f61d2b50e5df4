"""Which ground a frame shows, as a list of points of base_link: made once per camera, turned by every pose."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.capture.frame import Frame
from rover.vision.camera.model import CameraModel

# Ground farther ahead than this is too coarse in the picture to count as seen, metres.
MAX_SEEN_RANGE = 1.10
# Pixels next to the edge of the picture are not used.
EDGE_PX = 2.0


def view_polygon(camera: CameraModel, limit: float = MAX_SEEN_RANGE) -> NDArray[np.float64]:
    """Convex outline (N, 2) in base_link of the ground up to `limit` metres ahead that the camera shows."""
    edge = int(EDGE_PX)
    ground = camera.ground_lookup[edge:-edge, edge:-edge].reshape(-1, 2)
    ahead = ground[np.isfinite(ground).all(axis=1) & (ground[:, 0] <= limit)]
    return cv2.convexHull(ahead.astype(np.float32)).reshape(-1, 2).astype(np.float64)


class CameraView:
    """Ground points of base_link, on a lattice of half a cell, with the pixels that show them.

    points: (N, 2) metres; offset: the same from the camera's foot. maps: for cv2.remap, (N, 1, 2) float32 pixels.
    """

    def __init__(self, camera: CameraModel, spacing: float) -> None:
        self.camera = camera
        self.polygon = view_polygon(camera)
        low, high = self.polygon.min(axis=0), self.polygon.max(axis=0)
        x = np.arange(low[0], high[0] + spacing / 2, spacing)
        y = np.arange(low[1], high[1] + spacing / 2, spacing)
        points = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)
        uv = camera.ground_to_pixel(points.reshape(-1, 2)).reshape(points.shape)
        # An image of the lattice: row = x, column = y.
        self.inside = camera.inside(uv.reshape(-1, 2), EDGE_PX).reshape(points.shape[:2])
        self.points = points[self.inside].astype(np.float32)
        self.maps = uv[self.inside].astype(np.float32).reshape(-1, 1, 2)
        self.offset = self.points - np.array([camera.x, camera.y], np.float32)


def holds(frame: Frame, maps: NDArray[np.float32]) -> NDArray[np.bool_]:
    """Which points (N, 1, 2) of a picture the frame really holds, (N,)."""
    if frame.shown is None:
        return np.ones(len(maps), bool)
    columns, rows = np.round(maps[:, 0]).astype(np.intp).T
    inside: NDArray[np.bool_] = frame.shown[rows, columns]
    return inside
