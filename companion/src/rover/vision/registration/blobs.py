"""SIFT features (Lowe 2004): blobs of every size, for pairs in which corners of one size are not seen in the other.

They cost several times as much as ORB's; a picture larger than `side_px` is made smaller first, for only a first guess
is wanted of them.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class BlobSettings:
    """count: features wanted. contrast: OpenCV's contrastThreshold. side_px: longer side of the picture searched.

    ratio: best distance over the second best must not exceed it. min_inliers: fewer agreeing matches are a refusal;
    their descriptors tell more than ORB's, so fewer will do.
    """

    count: int = 1500
    contrast: float = 0.02
    side_px: int = 400
    ratio: float = 0.8
    min_inliers: int = 10


@dataclass(frozen=True, eq=False)
class Blobs:
    """points (N, 2) float64 pixels of the picture; descriptors (N, 128) float32, each of length 1."""

    points: NDArray[np.float64]
    descriptors: NDArray[np.float32]

    def __len__(self) -> int:
        return len(self.points)


def find_blobs(grey: NDArray[np.uint8], settings: BlobSettings) -> Blobs:
    """SIFT features of an 8-bit picture (H, W); none in a picture without texture."""
    share = min(1.0, settings.side_px / max(grey.shape))
    small = grey if share == 1.0 else cv2.resize(grey, None, fx=share, fy=share, interpolation=cv2.INTER_AREA)
    sift = cv2.SIFT.create(nfeatures=settings.count, contrastThreshold=settings.contrast)
    keypoints, computed = sift.detectAndCompute(small, None)
    if computed is None or len(keypoints) == 0:
        return Blobs(np.empty((0, 2)), np.empty((0, 128), np.float32))
    points = (np.asarray(cv2.KeyPoint.convert(keypoints), np.float64) + 0.5) / share - 0.5
    descriptors = np.asarray(computed, np.float32)
    return Blobs(points, descriptors / (np.linalg.norm(descriptors, axis=1, keepdims=True) + np.float32(1e-6)))


def blob_distances(a: Blobs, b: Blobs) -> NDArray[np.float32]:
    """Euclidean distances (N, M) of the descriptors."""
    squared: NDArray[np.float32] = np.maximum(np.float32(2.0) - np.float32(2.0) * (a.descriptors @ b.descriptors.T), 0)
    return np.sqrt(squared)
