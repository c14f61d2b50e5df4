"""What one frame shows of the ground: features by place, with what it takes to match them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rover.capture.frame import Frame
from rover.vision.camera.model import CameraModel
from rover.vision.localization.ground_pose import metres_per_pixel
from rover.vision.localization.ground_view import GroundView
from rover.vision.registration.features import FeatureDetector, FeatureSettings
from rover.vision.registration.preprocess import Preprocessor, PreprocessSettings

Array = NDArray[np.float64]
# Called with the name of a stage that has just ended: who measures gives a clock, a mission gives none.
Mark = Callable[[str], None]


def no_mark(_: str) -> None:
    """Measures nothing."""


@dataclass(frozen=True, eq=False)
class Observation:
    """One frame's features: ground (N, 2) in base_link, descriptors (N, 32), metres per pixel (N,) there."""

    ground: Array
    descriptors: NDArray[np.uint8]
    pixel_m: Array

    def __len__(self) -> int:
        return len(self.ground)


class Observer:
    """Counts to features on the ground; remembers the contrast limits and the FAST threshold of the last frame.

    A frame that becomes a keyframe is looked at again, more closely: which features a later frame will find is not
    known, so a keyframe that has more of them is met more often, at no cost to the many frames that become none.
    """

    def __init__(
        self,
        camera: CameraModel,
        preprocess: PreprocessSettings,
        features: FeatureSettings,
        keyframe_features: FeatureSettings,
    ) -> None:
        self.camera = camera
        self._view = GroundView(camera)
        self._preprocess = Preprocessor(preprocess)
        self._detector = FeatureDetector(features)
        self._closer = FeatureDetector(keyframe_features)
        self._picture = np.zeros((1, 1), np.uint8)

    def forget(self) -> None:
        """Drops the contrast limits: after a shutter event the old ones mean nothing."""
        self._preprocess.forget()

    def look(self, frame: Frame, mark: Mark = no_mark) -> Observation:
        """The features of one frame, none where there is no texture."""
        clean = self._preprocess.clean(frame.counts)
        mark("clean")
        laid = self._view.look(clean)
        mark("ground view")
        self._picture = self._preprocess.to_8_bit(laid)
        mark("contrast")
        seen = self._found(self._detector)
        mark("features")
        return seen

    def look_closer(self) -> Observation:
        """More features of the last frame."""
        return self._found(self._closer)

    def _found(self, detector: FeatureDetector) -> Observation:
        features = detector.detect(self._picture, self._view.mask)
        ground = self._view.to_base(features.points)
        _, depth = self.camera.ground_to_normalized(ground)
        return Observation(ground, features.descriptors, metres_per_pixel(depth, self.camera))
