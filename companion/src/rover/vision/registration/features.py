"""ORB features spread over the picture, with a FAST threshold that follows the contrast (eq. 1 to 5 of the paper).

OpenCV's ORB does FAST (eq. 1), the orientation by intensity moments (eq. 2 to 4) and steered BRIEF (eq. 5).
What it lacks for thermal pictures is here: the threshold adapts until there are enough keypoints, and the strongest
of every cell of a grid are kept, so that one hot rock does not take them all.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class FeatureSettings:
    """count: features wanted. columns, rows: cells over which they are spread. threshold_*: FAST threshold's range.

    surplus: keypoints asked for, as a multiple of `count`, so that there is a choice when they are spread.
    patch: side of the BRIEF patch in pixels; features closer than this to the edge are not found.
    """

    count: int = 300
    columns: int = 8
    rows: int = 6
    levels: int = 3
    scale: float = 1.3
    patch: int = 25
    surplus: int = 3
    threshold_start: int = 12
    threshold_min: int = 4
    threshold_max: int = 60


@dataclass(frozen=True, eq=False)
class Features:
    """points (N, 2) float64 pixels, descriptors (N, 32) uint8, scale (N,) size of a pixel of their pyramid level."""

    points: NDArray[np.float64]
    descriptors: NDArray[np.uint8]
    scale: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.points)

    def take(self, chosen: NDArray[np.intp] | NDArray[np.bool_]) -> Features:
        """The features of that selection."""
        return Features(self.points[chosen], self.descriptors[chosen], self.scale[chosen])


NO_FEATURES = Features(np.empty((0, 2)), np.empty((0, 32), np.uint8), np.empty(0))


@dataclass
class FeatureDetector:
    """ORB with memory of the FAST threshold that suited the last picture."""

    settings: FeatureSettings = field(default_factory=FeatureSettings)
    threshold: int = 0

    def __post_init__(self) -> None:
        s = self.settings
        self.threshold = self.threshold or s.threshold_start
        self._orb = cv2.ORB.create(
            nfeatures=s.surplus * s.count,
            scaleFactor=s.scale,
            nlevels=s.levels,
            edgeThreshold=s.patch // 2 + 2,
            patchSize=s.patch,
            fastThreshold=self.threshold,
        )

    def detect(self, picture: NDArray[np.uint8], mask: NDArray[np.uint8] | None = None) -> Features:
        """Features of an 8-bit picture (H, W), where `mask` (H, W) is not 0; none in a picture without texture."""
        keypoints = self._keypoints(picture, mask)
        if not keypoints:
            return NO_FEATURES
        height, width = picture.shape
        chosen = spread(keypoints, width, height, self.settings)
        keypoints, computed = self._orb.compute(picture, [keypoints[i] for i in chosen])
        if computed is None:
            return NO_FEATURES  # type: ignore[unreachable]  # the stub does not know that there may be none
        descriptors = np.asarray(computed, np.uint8)
        points = np.asarray(cv2.KeyPoint.convert(keypoints), np.float64)
        if self.settings.levels == 1:
            return Features(points, descriptors, np.ones(len(points)))
        octave = np.array([k.octave for k in keypoints], dtype=np.float64)
        return Features(points, descriptors, self.settings.scale**octave)

    def _keypoints(self, picture: NDArray[np.uint8], mask: NDArray[np.uint8] | None) -> Sequence[cv2.KeyPoint]:
        """At most two tries: a picture much poorer than the last gets a lower threshold at once."""
        s = self.settings
        self._orb.setFastThreshold(self.threshold)
        keypoints = self._orb.detect(picture, mask)
        if len(keypoints) < s.count // 2 and self.threshold > s.threshold_min:
            self.threshold = max(s.threshold_min, self.threshold // 2)
            self._orb.setFastThreshold(self.threshold)
            keypoints = self._orb.detect(picture, mask)
        if len(keypoints) < s.count * s.surplus // 2:
            self.threshold = max(s.threshold_min, self.threshold - 1)
        elif len(keypoints) > s.count * (2 * s.surplus - 1) // 2:
            self.threshold = min(s.threshold_max, self.threshold + 1)
        return keypoints


def spread(keypoints: Sequence[cv2.KeyPoint], width: int, height: int, settings: FeatureSettings) -> NDArray[np.intp]:
    """Indices of at most `count` keypoints: the cells of a grid take turns, each giving its strongest first."""
    if len(keypoints) <= settings.count:
        return np.arange(len(keypoints))
    points = np.asarray(cv2.KeyPoint.convert(keypoints), np.float64)
    response = np.array([k.response for k in keypoints])
    column = np.minimum((points[:, 0] * settings.columns / width).astype(int), settings.columns - 1)
    row = np.minimum((points[:, 1] * settings.rows / height).astype(int), settings.rows - 1)
    cell = row * settings.columns + column
    by_cell = np.lexsort((np.arange(len(points)), -response, cell))
    ordered = cell[by_cell]
    first_of_cell = np.searchsorted(ordered, ordered, side="left")
    rank = np.arange(len(points)) - first_of_cell
    turns = np.lexsort((-response[by_cell], rank))
    return np.sort(by_cell[turns[: settings.count]])
