"""Vectors and labels out of real pictures of a mined field: real texture, at a scale in kelvin that nobody knows."""

from __future__ import annotations

from collections.abc import Container
from pathlib import Path

import numpy as np
from rover.detection.candidates import find_candidates
from rover.detection.classifier import CLASSES
from rover.detection.ground_image import METRES_PER_PIXEL, from_picture
from rover.detection.patch import describe
from rover_hil.ground.pictures import Entry, deviations, distinct, read_index

from tools.train.samples import Samples

# The scale of a stretched picture is unknown: every picture is learned at several.
SCALES = (0.5, 1.5)
# Background candidates kept per picture and scale.
MOST_BACKGROUND = 5


def zones(data: Path) -> list[str]:
    """Names of the zones that have labelled pictures."""
    return sorted({entry.zone for entry in read_index(data) if entry.boxes})


def from_pictures(data: Path, chosen: Container[str], seed: int) -> Samples:
    """Candidates of the pictures of the zones `chosen`, each at two scales and in a random orientation."""
    rng = np.random.default_rng([seed, 80])
    parts = []
    for entry in distinct(read_index(data)):
        if entry.zone not in chosen or not entry.boxes:
            continue
        kelvin = deviations(data, entry, METRES_PER_PIXEL)
        for scale in SCALES:
            parts.append(_of_picture(kelvin * np.float32(scale * rng.uniform(0.7, 1.4)), entry, rng))
    return Samples.join(parts)


def _of_picture(kelvin: np.ndarray, entry: Entry, rng: np.random.Generator) -> Samples:
    """Candidates of one picture; boxes are in metres from its upper left corner."""
    flip_rows, flip_columns = rng.random(2) < 0.5
    turned = kelvin[:: -1 if flip_rows else 1, :: -1 if flip_columns else 1]
    noisy = turned + rng.normal(0, 0.05, turned.shape).astype(np.float32)
    image = from_picture(noisy, METRES_PER_PIXEL)
    rows, columns = image.kelvin.shape
    vectors, labels = [], []
    background = 0
    candidates = find_candidates(image, most=40)
    for candidate, vector in zip(candidates, describe(image, candidates), strict=True):
        row = rows - 1 - candidate.row if flip_rows else candidate.row
        column = columns - 1 - candidate.column if flip_columns else candidate.column
        name = _label((column + 0.5) * METRES_PER_PIXEL, (row + 0.5) * METRES_PER_PIXEL, entry)
        if name is None or (name == "background" and background >= MOST_BACKGROUND):
            continue
        background += name == "background"
        vector[-1] = rng.uniform(0.3, 1.1)  # the range at which the rover would have seen it
        vectors.append(vector)
        labels.append(CLASSES.index(name))
    if not labels:
        return Samples.join([])
    return Samples(np.array(vectors, np.float32), np.array(labels, np.int64))


def _label(x: float, y: float, entry: Entry) -> str | None:
    """Class of a point of the picture (metres from its upper left corner); None between mine and ground."""
    for cx, cy, width, height in entry.boxes:
        distance = max(abs(x - cx) / width, abs(y - cy) / height)
        if distance < 0.3 and np.hypot(x - cx, y - cy) < 0.10:
            return "surface" if entry.depth == 0.0 else "buried"
        if distance < 0.9:
            return None
    return "background"
