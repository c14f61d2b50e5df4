"""What registration works out of one picture, once for all its pairs, and the rest when it is first asked for."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.vision.registration.blobs import Blobs, find_blobs
from rover.vision.registration.features import FeatureDetector, Features
from rover.vision.registration.preprocess import Image, Preprocessor, local_contrast
from rover.vision.registration.settings import RegistrationSettings

Grey = NDArray[np.uint8]
Picture = NDArray[np.uint8] | NDArray[np.uint16]
Points = NDArray[np.float64]
# Local contrast in full, half and quarter size.
Pyramid = list[Grey]

LEVELS = 3
# Sides below which a picture shows nothing that could be followed.
LEAST_SIDE_PX = 16


@dataclass(frozen=True, eq=False)
class Prepared:
    """image: (H, W) float32, as delivered. grey: (H, W) uint8, preprocessed. features: of `grey`."""

    image: Image
    grey: Grey
    features: Features
    settings: RegistrationSettings

    @property
    def shape(self) -> tuple[int, ...]:
        """(H, W)."""
        return self.image.shape

    @cached_property
    def pyramid(self) -> Pyramid:
        """Local contrast in full, half and quarter size."""
        return pyramid(self.image)

    @property
    def sharp(self) -> Grey:
        """Local contrast in full size."""
        return self.pyramid[0]

    @cached_property
    def blobs(self) -> Blobs:
        """SIFT features: dear, and only asked for where ORB's were not enough."""
        return find_blobs(self.grey, self.settings.blobs)


def prepare(picture: Picture, settings: RegistrationSettings) -> Prepared:
    """One picture (H, W) of 8 or 16 bits, ready for `register_prepared`."""
    grey = Preprocessor(settings.preprocess)(picture)
    return Prepared(picture.astype(np.float32), grey, FeatureDetector(settings.features).detect(grey), settings)


def find_features(picture: Picture, settings: RegistrationSettings) -> Features:
    """The features of one picture (H, W) of 8 or 16 bits."""
    return prepare(picture, settings).features


def pyramid(image: Image) -> Pyramid:
    """Local contrast of a picture (H, W), full size first, each half of the one before."""
    levels = [local_contrast(image)]
    while len(levels) < LEVELS:
        levels.append(np.asarray(cv2.pyrDown(levels[-1]), np.uint8))
    return levels


def shrunk(image: Image, factor: float) -> tuple[Image, Points]:
    """The picture (H, W) made smaller by `factor` (0 to 1), and the homography (3, 3) into it."""
    height, width = image.shape
    size = max(LEAST_SIDE_PX, round(width * factor)), max(LEAST_SIDE_PX, round(height * factor))
    x, y = size[0] / width, size[1] / height
    # Centres of pixels lie at whole numbers.
    into = np.array([[x, 0.0, 0.5 * x - 0.5], [0.0, y, 0.5 * y - 0.5], [0.0, 0.0, 1.0]])
    return np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA), np.float32), into
