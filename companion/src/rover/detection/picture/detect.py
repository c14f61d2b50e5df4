"""One picture without kelvin to detections: spots of every size, what the classifier says, one box for each thing."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from rover.detection.classifier import MINES, Classifier
from rover.detection.picture.candidates import find_spots, first_of_each
from rover.detection.picture.features import shipped_features
from rover.detection.picture.maps import picture_maps
from rover.detection.picture.patch import describe_spots
from rover.errors import BadInput

# Detections whose centres are nearer than this share of the wider one are the same thing; the likelier stays.
SAME = 0.5
MAX_DETECTIONS = 25


@dataclass(frozen=True)
class PictureDetection:
    """x, y: centre, extent: diameter, pixels of the picture. p: probability of every class."""

    x: float
    y: float
    extent: float
    p: dict[str, float]

    @property
    def mine_probability(self) -> float:
        """Probability of a mine of either kind."""
        return sum(self.p[name] for name in MINES)


def detect_in_picture(
    grey: NDArray[np.float32], classifier: Classifier, metres_per_pixel: float | None = None
) -> list[PictureDetection]:
    """What lies in a picture (h, w) of grey levels 0 to 255, likeliest mines first; at most MAX_DETECTIONS.

    Raises BadInput where the classifier was trained with other features than those that ship.
    """
    features = shipped_features()
    if classifier.features_sha256 != features.sha256:
        raise BadInput(f"{classifier.path}: trained with other features; train one with python -m tools.train pictures")
    maps = picture_maps(grey)
    spots = find_spots(maps, metres_per_pixel)
    if not len(spots):
        return []
    p = classifier.predict(describe_spots(maps, spots, features))
    mine = _mine(p, classifier)
    kept = thin(spots, mine, MAX_DETECTIONS)
    return [
        PictureDetection(x, y, extent, dict(zip(classifier.classes, probabilities, strict=True)))
        for (x, y, extent), probabilities in zip(spots[kept].tolist(), p[kept].tolist(), strict=True)
    ]


@lru_cache(maxsize=1)
def prepare(classifier: Classifier) -> None:
    """Does once what libraries do slowly the first time, on a picture of noise."""
    noise = np.random.default_rng(0).integers(0, 255, (240, 320))
    detect_in_picture(noise.astype(np.float32), classifier)


def _mine(p: NDArray[np.float32], classifier: Classifier) -> NDArray[np.float32]:
    mine: NDArray[np.float32] = p[:, [classifier.classes.index(name) for name in MINES]].sum(axis=1)
    return mine


def thin(spots: NDArray[np.float32], score: NDArray[np.float32], most: int) -> list[int]:
    """Indices of the spots that stay, highest score first: none within another's place."""
    order = np.argsort(-score, kind="stable")
    x, y, extent = spots[order].T
    apart = np.maximum(np.abs(x[:, None] - x), np.abs(y[:, None] - y))
    same = apart <= SAME * np.maximum(extent[:, None], extent)
    return [int(index) for index in order[first_of_each(same, most)]]
