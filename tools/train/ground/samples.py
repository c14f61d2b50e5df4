"""Vectors and truth out of synthetic fields, by the same path that the rover uses."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rover.detection.classifier import CLASSES
from rover.detection.ground.candidates import find_candidates
from rover.detection.ground.detect import toned
from rover.detection.ground.image import GroundRectifier
from rover.detection.ground.patch import LENGTH, SIDE, describe
from rover.vision.camera.model import CameraModel

from tools.train.ground.fields import make_field, views
from tools.train.ground.look import in_view, kind_of, truth_of

# A candidate this near to the middle of a mine's picture is learned as the mine; up to AMBIGUOUS it is neither. Metres.
NEAR, AMBIGUOUS = 0.06, 0.10
# A candidate this near to an obstacle's picture is learned as the obstacle; up to BESIDE it is neither.
ON_OBSTACLE, BESIDE = 0.01, 0.06
# Nothing is learned from mines weaker than this, kelvin at the surface.
MIN_LEARNED_KELVIN = 0.25
# One detection counts for a mine within its half-extent and this much more, metres.
HALO = 0.10
UNSURE = -1
OBSTACLE, BACKGROUND = CLASSES.index("obstacle"), CLASSES.index("background")
# Layers of a vector that are pictures: they may be turned.
PICTURES = 3


@dataclass(frozen=True, eq=False)
class Looks:
    """Candidates of many looks at synthetic fields, and the mines that were in view.

    vectors (N, LENGTH) float32. Of each candidate (N,): `look`, which one; `mine`, the number of the nearest mine in
    its field or -1, its class `kind`, its `contrast` (K, positive), its `radius` and the distance `to_mine` from the
    middle of its picture (m); `to_obstacle` as `look.Truth` has it.
    seen (M, 4): look, mine, class and contrast of every mine in view of a look. field (looks,): its field's seed.
    """

    vectors: NDArray[np.float32]
    look: NDArray[np.int64]
    mine: NDArray[np.int64]
    kind: NDArray[np.int64]
    contrast: NDArray[np.float32]
    radius: NDArray[np.float32]
    to_mine: NDArray[np.float32]
    to_obstacle: NDArray[np.float32]
    seen: NDArray[np.float32]
    field: NDArray[np.int64]

    def __post_init__(self) -> None:
        if self.vectors.shape[1:] != (LENGTH,) or self.vectors.dtype != np.float32:
            raise ValueError(f"vectors {self.vectors.shape} {self.vectors.dtype}: (N, {LENGTH}) float32 is expected")

    def __len__(self) -> int:
        return len(self.look)

    @staticmethod
    def join(parts: Iterable[Looks]) -> Looks:
        """All of them, in order; looks are counted on."""
        parts, before, shifted = list(parts), 0, []
        for part in parts:
            seen = part.seen.copy()
            seen[:, 0] += before
            shifted.append({**vars(part), "look": part.look + before, "seen": seen})
            before += len(part.field)
        return Looks(**{f.name: np.concatenate([part[f.name] for part in shifted]) for f in fields(Looks)})

    @property
    def on_mine(self) -> NDArray[np.bool_]:
        """Where a detection would count for the nearest mine."""
        return (self.to_mine <= self.radius + HALO) & (self.to_obstacle >= ON_OBSTACLE)

    @property
    def on_obstacle(self) -> NDArray[np.bool_]:
        """Where a candidate is an obstacle."""
        return self.to_obstacle < ON_OBSTACLE

    @property
    def on_ground(self) -> NDArray[np.bool_]:
        """Where a detection would be a false alarm: outside every mine's halo, and not at an obstacle's edge."""
        return (self.to_mine > self.radius + HALO) & (self.to_obstacle >= BESIDE)

    def labels(self, weakest: float = MIN_LEARNED_KELVIN) -> NDArray[np.int64]:
        """What each candidate is learned as, (N,) into CLASSES; UNSURE between two, and at mines below `weakest` K."""
        labels = np.full(len(self), BACKGROUND)
        labels[self.to_mine < AMBIGUOUS] = UNSURE
        mine = (self.to_mine < NEAR) & (self.contrast >= weakest)
        labels[mine] = self.kind[mine]
        labels[self.to_obstacle < BESIDE] = UNSURE
        labels[self.on_obstacle] = OBSTACLE
        return labels


def look_at_fields(
    camera: CameraModel,
    soils: tuple[str, ...],
    seeds: Iterable[int],
    frames: int,
    held_out: bool,
    data: Path | None = None,
) -> Looks:
    """`frames` looks at the field of each seed; held_out: at the hours held out, else at the others.

    Those held out are to be judged, as the rover does it; from the others contrasts are learned as they are.
    """
    rectifier = GroundRectifier(camera)
    vectors = [np.zeros((0, LENGTH), np.float32)]
    rows: list[tuple[float, ...]] = []
    seen: list[tuple[float, ...]] = []
    field_of: list[int] = []
    for seed in seeds:
        field = make_field(camera, soils, seed, data, held_out)
        if field is None:
            continue
        mines = field.ground.mines
        for pose, frame in views(field, camera, frames, seed):
            image = rectifier.rectify(frame)
            candidates = find_candidates(image)
            points = image.to_base(np.array([(c.row, c.column) for c in candidates]).reshape(-1, 2))
            truth = truth_of(points, pose, field.ground, camera)
            look = len(field_of)
            for number, distance, outside in zip(truth.mine, truth.to_mine, truth.to_obstacle, strict=True):
                nearest = (kind_of(mines[number]), abs(mines[number].contrast_k), mines[number].radius)
                rows.append((look, number, *(nearest if number >= 0 else (BACKGROUND, 0.0, 0.0)), distance, outside))
            vectors.append(describe(toned(image, candidates) if held_out else image, candidates))
            for number in in_view(image, pose, field.ground, camera):
                seen.append((look, number, kind_of(mines[number]), abs(mines[number].contrast_k)))
            field_of.append(seed)
    table = np.array(rows, np.float64).reshape(-1, 7).T
    of_look, mine, kind = (column.astype(np.int64) for column in table[:3])
    contrast, radius, to_mine, to_obstacle = (column.astype(np.float32) for column in table[3:])
    sights = np.array(seen, np.float32).reshape(-1, 4)
    of_field = np.array(field_of, np.int64)
    return Looks(np.concatenate(vectors), of_look, mine, kind, contrast, radius, to_mine, to_obstacle, sights, of_field)


_INDEX = np.arange(SIDE * SIDE).reshape(SIDE, SIDE)
_REST = np.arange(PICTURES * SIDE * SIDE, LENGTH)
_WAYS = [np.rot90(side, turn).ravel() for side in (_INDEX, _INDEX[:, ::-1]) for turn in range(4)]
# (8, LENGTH): where each number of a vector comes from when its pictures are turned; 0 as it is, 4 mirrored.
WAYS = np.array([np.concatenate((*(way + n * SIDE * SIDE for n in range(PICTURES)), _REST)) for way in _WAYS])


def turned(vectors: NDArray[np.float32], labels: NDArray[np.integer], rng: np.random.Generator) -> NDArray[np.float32]:
    """The same candidates with their pictures turned by chance: neither heat nor soil knows a direction.

    What stands out of the ground is drawn out away from the camera: it is mirrored only.
    """
    flat = np.isin(labels, (CLASSES.index("buried"), BACKGROUND))
    way = np.where(flat, rng.integers(0, 8, len(labels)), 4 * rng.integers(0, 2, len(labels)))
    for number in range(1, 8):
        some = np.flatnonzero(way == number)
        vectors[some] = vectors[some][:, WAYS[number]]
    return vectors
