"""Synthetic fields to learn from and to test on, kept in parts so that another round begins at once."""

from __future__ import annotations

from pathlib import Path

from numpy.typing import NDArray
from rover.vision.camera import CameraModel

from tools.train.samples import Samples, from_fields
from tools.train.store import kept


def field_samples(
    camera: CameraModel, soils: tuple[str, ...], seeds: range, frames: int, weakest: float, cache: Path | None
) -> Samples:
    """Samples of synthetic fields, one stored part for each 90 of them."""
    parts = []
    for first in range(seeds.start, seeds.stop, 90):
        part = range(first, min(first + 90, seeds.stop))
        name = f"fields-{'+'.join(soils)}-{part.start}-{len(part)}-{frames}-{weakest:g}"

        def make(part: range = part) -> dict[str, NDArray]:
            samples = from_fields(camera, soils, part, frames, weakest=weakest)
            return {"vectors": samples.vectors, "labels": samples.labels}

        parts.append(Samples(**kept(cache, name, make)))
    return Samples.join(parts)
