"""One ground image to detections: candidates, their probabilities, and where they lie in base_link."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from rover.detection.classifier import Classifier
from rover.detection.ground.candidates import EXTENT_PER_WIDTH, WIDTHS, Candidate, find_candidates
from rover.detection.ground.image import GroundImage
from rover.detection.ground.patch import describe

# The middle of the picture of a mine on the surface lies this high above the soil, metres.
CASING_MIDDLE = 0.03
# What the ground answers at the narrowest scale, robust standard deviation in kelvin, where it is as rough as most of
# what the network has learned from.
KNOWN_GROUND = 0.12


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
    probabilities = classifier.predict(describe(toned(image, candidates), candidates))
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


def toned(image: GroundImage, candidates: Sequence[Candidate]) -> GroundImage:
    """The image as it is judged: ground rougher than KNOWN_GROUND has its contrasts lowered to that.

    Contrast is evidence of a mine by how far it stands out of the soil's own. Lower it is not raised: what is left then
    is the camera's noise.
    """
    narrow = 1.01 * EXTENT_PER_WIDTH * WIDTHS[0]
    rough = next((abs(c.answer) / c.strength for c in candidates if c.extent < narrow and c.strength > 0.0), 0.0)
    if rough <= KNOWN_GROUND:
        return image
    plain = (image.kelvin - np.float32(image.median)) * np.float32(KNOWN_GROUND / rough)
    return replace(image, kelvin=plain + np.float32(image.median), known_median=image.median)


def _foot(x: float, y: float, surface: float, eye: tuple[float, float, float] | None) -> tuple[float, float]:
    """Where a thing stands whose picture is at (x, y): a casing above the soil appears farther from the lens."""
    if eye is None:
        return x, y
    back = surface * CASING_MIDDLE / eye[2]
    return x - back * (x - eye[0]), y - back * (y - eye[1])


def _box(candidate: Candidate, metres_per_pixel: float) -> tuple[int, int, int, int]:
    side = max(1, round(candidate.extent / metres_per_pixel))
    return (round(candidate.row - side / 2), round(candidate.column - side / 2), side, side)
