"""Vectors and labels out of synthetic fields, by the same path that the rover uses."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rover.detection.candidates import Candidate, find_candidates
from rover.detection.classifier import CLASSES
from rover.detection.ground_image import GroundRectifier
from rover.detection.patch import LENGTH, SIDE, describe
from rover.vision.camera import CameraModel

from tools.train.fields import make_field, views
from tools.train.labels import LEAST_CONTRAST, UNSURE, label

# Candidates that are no mines are many: of these, this share is learned from. Small strong spots of the ground
# (pebbles, and pixels that answer differently) are all kept: they may not be taken for obstacles.
SHARES = {"background": 0.35, "obstacle": 0.5}
SPOT_EXTENT, SPOT_KELVIN = 0.07, 0.5


@dataclass(frozen=True, eq=False)
class Samples:
    """vectors (N, LENGTH) float32; labels (N,) index into CLASSES."""

    vectors: NDArray[np.float32]
    labels: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.labels)

    @staticmethod
    def join(parts: Iterable[Samples]) -> Samples:
        """All of them, in order."""
        parts = list(parts)
        return Samples(
            np.concatenate([np.zeros((0, LENGTH), np.float32), *(p.vectors for p in parts)]),
            np.concatenate([np.zeros(0, np.int64), *(p.labels for p in parts)]),
        )

    def counts(self) -> dict[str, int]:
        """How many of each class."""
        return {name: int((self.labels == i).sum()) for i, name in enumerate(CLASSES)}


def from_fields(
    camera: CameraModel,
    soils: tuple[str, ...],
    seeds: Iterable[int],
    frames: int,
    data: Path | None = None,
    weakest: float = LEAST_CONTRAST,
) -> Samples:
    """Candidates of `frames` frames of the field of each seed; with `data`, on real texture.

    Mines below `weakest` kelvin are left out.
    """
    rectifier = GroundRectifier(camera)
    parts = []
    for seed in seeds:
        field = make_field(camera, soils, seed, data)
        if field is None:
            continue
        rng = np.random.default_rng([seed, 79])
        for pose, frame in views(field, camera, frames, seed):
            image = rectifier.rectify(frame)
            candidates = find_candidates(image)
            if not candidates:
                continue
            points = image.to_base(np.array([(c.row, c.column) for c in candidates]))
            names = label(points, pose, field.ground, camera, weakest)
            keep = [n != UNSURE and _is_kept(n, c, rng) for n, c in zip(names, candidates, strict=True)]
            parts.append(
                Samples(
                    describe(image, candidates)[keep],
                    np.array([CLASSES.index(n) for n, k in zip(names, keep, strict=True) if k], np.int64),
                )
            )
    return Samples.join(parts)


def _is_kept(name: str, candidate: Candidate, rng: np.random.Generator) -> bool:
    spot = name == "background" and candidate.extent < SPOT_EXTENT and abs(candidate.answer) > SPOT_KELVIN
    return bool(rng.random() < SHARES.get(name, 1.0)) or spot


def mirrored(samples: Samples) -> Samples:
    """The same with left and right exchanged: neither the heat nor the camera knows a side."""
    vectors = samples.vectors.copy()
    area = SIDE * SIDE
    for start in (0, area, 2 * area):
        patches = samples.vectors[:, start : start + area].reshape(-1, SIDE, SIDE)
        vectors[:, start : start + area] = patches[:, :, ::-1].reshape(-1, area)
    return Samples(vectors, samples.labels)
