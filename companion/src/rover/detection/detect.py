"""One ground image to detections: candidates, their probabilities, and where they lie in base_link."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rover.detection.candidates import Candidate, find_candidates
from rover.detection.classifier import Classifier
from rover.detection.ground_image import GroundImage
from rover.detection.patch import describe

# The middle of the picture of a mine on the surface lies this high above the soil, metres.
CASING_MIDDLE = 0.03


@dataclass(frozen=True)
class DetectSettings:
    """least_other: a candidate is dropped when it is background with more than 1 - least_other."""

    least_other: float = 0.0


@dataclass(frozen=True)
class Detection:
    """A classified candidate.

    x, y: centre in base_link, metres. extent: diameter, metres. p: probability of every class, sums to one.
    bbox: (row, column, height, width) in pixels of the ground image. answer: contrast of the blob, kelvin.
    """

    x: float
    y: float
    extent: float
    p: dict[str, float]
    bbox: tuple[int, int, int, int]
    answer: float = 0.0

    @property
    def label(self) -> str:
        """The most probable class."""
        return max(self.p, key=lambda name: (self.p[name], name))


def detect(image: GroundImage, classifier: Classifier, settings: DetectSettings) -> list[Detection]:
    """Every candidate of the picture with its probabilities, strongest contrast first."""
    candidates = find_candidates(image)
    if not candidates:
        return []
    probabilities = classifier.predict(describe(image, candidates))
    points = image.to_base(np.array([(c.row, c.column) for c in candidates]))
    found = []
    for candidate, row, point in zip(candidates, probabilities.tolist(), points.tolist(), strict=True):
        p = dict(zip(classifier.classes, row, strict=True))
        x, y = _foot(point[0], point[1], p["surface"], image.eye)
        if 1.0 - p["background"] >= settings.least_other:
            found.append(
                Detection(x, y, candidate.extent, p, _box(candidate, image.metres_per_pixel), candidate.answer)
            )
    return found


def _foot(x: float, y: float, surface: float, eye: tuple[float, float, float] | None) -> tuple[float, float]:
    """Where a thing stands whose picture is at (x, y): a casing above the soil appears farther from the lens."""
    if eye is None:
        return x, y
    back = surface * CASING_MIDDLE / eye[2]
    return x - back * (x - eye[0]), y - back * (y - eye[1])


def _box(candidate: Candidate, metres_per_pixel: float) -> tuple[int, int, int, int]:
    side = max(1, round(candidate.extent / metres_per_pixel))
    return (round(candidate.row - side / 2), round(candidate.column - side / 2), side, side)
