"""Synthetic fields to learn from and to test on, kept in parts so that another round begins at once."""

from __future__ import annotations

from pathlib import Path

import rover_hil.ground
from rich.console import Console
from rich.progress import track
from rover.detection.ground import candidates, detect, image, patch
from rover.vision.camera.model import CameraModel

from tools.train.ground import fields, look, samples
from tools.train.ground.samples import Looks, look_at_fields
from tools.train.store import Arrays, digest, kept

# Fields of one stored part.
PART = 100
MODULES = (candidates, detect, image, patch, fields, look, samples)
SOURCES = (
    *(Path(str(module.__file__)) for module in MODULES),
    *sorted(Path(str(rover_hil.ground.__file__)).parent.glob("*.py")),
)


def field_looks(
    camera: CameraModel, of_soils: tuple[str, ...], seeds: range, frames: int, held_out: bool, cache: Path | None
) -> Looks:
    """Looks at synthetic fields of these seeds; progress on stderr."""
    parts, code = [], digest(SOURCES)
    for first in range(seeds.start, seeds.stop, PART):
        part = range(first, min(first + PART, seeds.stop))
        when = "held-out" if held_out else "other"
        name = f"looks-{code}-{'+'.join(of_soils)}-{when}-{part.start}-{len(part)}-{frames}"

        def make(part: range = part) -> Arrays:
            title = f"fields {part.start} to {part.stop - 1}, {', '.join(of_soils)}"
            shown = track(part, title, console=Console(stderr=True))
            return dict(vars(look_at_fields(camera, of_soils, shown, frames, held_out)))

        parts.append(Looks(**kept(cache, name, make)))
    return Looks.join(parts)
