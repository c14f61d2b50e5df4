"""Vectors and labels out of real pictures, by the code that `rover detect` runs.

Every sample remembers its picture, so that whole zones and sessions can be held out of one set of vectors.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from rover.detection.picture.candidates import find_spots
from rover.detection.picture.features import shipped_features
from rover.detection.picture.maps import picture_maps
from rover.detection.picture.patch import describe_spots

from tools.train.picture.augment import from_another_height, restyled, turned, with_disc
from tools.train.picture.records import Box, Record

# What a sample is: a candidate as the detector finds it, a labelled box itself, a window beside the boxes.
CANDIDATE, BOX, WINDOW, JITTERED = 0, 1, 2, 3
MINE_UNKNOWN, SURFACE, BURIED, BACKGROUND, UNSURE = -1, 1, 2, 3, -2
# The box of a casing that was drawn into the picture; -1 is none.
DRAWN = -2
WINDOWS_PER_BOX = 3
JITTERS = 6
# Shares of the candidates of an altered picture that are learned from.
MINES_KEPT, GROUND_KEPT = 0.8, 0.25
DISC_SHARE, ZOOMED_SHARE = 0.5, 0.5
# A centre this share of a box outside of it is not yet ground.
HALO = 0.15


@dataclass(frozen=True, eq=False)
class PictureSamples:
    """vectors (N, LENGTH) float16; what, truth, picture, box, round (N,) int; spots (N, 3) x, y, diameter.

    truth: SURFACE, BURIED, BACKGROUND as in CLASSES, MINE_UNKNOWN of a mine whose kind is not told, UNSURE between.
    box: which of the picture's labelled boxes, -1 or DRAWN. round: 0 is the picture as it lies on disk, others are
    altered ones.
    """

    vectors: NDArray[np.float16]
    what: NDArray[np.int8]
    truth: NDArray[np.int8]
    picture: NDArray[np.int32]
    box: NDArray[np.int16]
    round: NDArray[np.int8]
    spots: NDArray[np.float32]

    def __len__(self) -> int:
        return len(self.truth)

    def take(self, rows: NDArray[np.intp]) -> PictureSamples:
        """Some of them."""
        return PictureSamples(*(getattr(self, name)[rows] for name in self.__dataclass_fields__))

    @staticmethod
    def join(parts: Sequence[PictureSamples]) -> PictureSamples:
        """All of them, in order."""
        names = PictureSamples.__dataclass_fields__
        return PictureSamples(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))


def sample_picture(record: Record, number: int, turn: int, seed: int) -> PictureSamples:
    """The samples of one picture; turn 0: as on disk, every candidate; others: altered at random, fewer of them."""
    rng = np.random.default_rng([seed, number, turn, 83])
    picture, boxes = record.grey.astype(np.float32), record.boxes
    if turn:
        picture, boxes = turned(record, rng)
        if rng.random() < ZOOMED_SHARE:
            picture, boxes = from_another_height(picture, boxes, rng)
        if rng.random() < DISC_SHARE:
            picture, boxes = with_disc(picture, boxes, rng)
        picture = restyled(picture, rng)
    maps = picture_maps(picture)
    found = find_spots(maps)
    truth, which = label_spots(found, boxes)
    if turn:
        kept = rng.random(len(found)) < np.where(truth == BACKGROUND, GROUND_KEPT, MINES_KEPT)
        chosen = np.nonzero(kept & (truth != UNSURE))[0]
    else:
        chosen = np.arange(len(found))
    exact = np.array([(b.x, b.y, b.side) for b in boxes], np.float32).reshape(-1, 3)
    windows = _windows(boxes, picture.shape, rng)
    jittered = _jittered(boxes, rng)
    jitter_truth, jitter_which = label_spots(jittered, boxes)
    spots = np.concatenate((found[chosen], exact, windows, jittered)).astype(np.float32)
    of_box = np.array([_kind(b) for b in boxes], np.int8)
    counts = (len(chosen), len(exact), len(windows), len(jittered))
    keep = np.concatenate((np.ones(sum(counts[:3]), bool), jitter_truth != UNSURE))
    box = np.concatenate((which[chosen], np.arange(len(exact)), np.full(len(windows), -1), jitter_which))
    box[box >= len(record.boxes)] = DRAWN
    samples = PictureSamples(
        describe_spots(maps, spots, shipped_features()).astype(np.float16),
        np.repeat(np.array((CANDIDATE, BOX, WINDOW, JITTERED), np.int8), counts),
        np.concatenate((truth[chosen], of_box, np.full(len(windows), BACKGROUND, np.int8), jitter_truth)),
        np.full(sum(counts), number, np.int32),
        box.astype(np.int16),
        np.full(sum(counts), turn, np.int8),
        spots,
    )
    return samples.take(np.nonzero(keep)[0])


def label_spots(spots: NDArray[np.float32], boxes: Sequence[Box]) -> tuple[NDArray[np.int8], NDArray[np.int16]]:
    """Truth (N,) of spots and the box each belongs to, -1 for none. UNSURE: centre in a box, but does not fit it."""
    truth = np.full(len(spots), BACKGROUND, np.int8)
    which = np.full(len(spots), -1, np.int16)
    x, y, extent = spots.T
    for index, box in enumerate(boxes):
        dx, dy = np.abs(x - box.x), np.abs(y - box.y)
        touches = (dx < (0.5 + HALO) * box.width) & (dy < (0.5 + HALO) * box.height)
        fits = (dx < 0.3 * box.width) & (dy < 0.3 * box.height)
        fits &= (extent > 0.55 * box.side) & (extent < 1.8 * box.side)
        truth[touches & (truth == BACKGROUND)] = UNSURE
        which[touches & (which < 0)] = index
        truth[fits], which[fits] = _kind(box), index
    return truth, which


def _kind(box: Box) -> int:
    return {"surface": SURFACE, "buried": BURIED}.get(box.kind, MINE_UNKNOWN)


def _windows(boxes: Sequence[Box], shape: tuple[int, int], rng: np.random.Generator) -> NDArray[np.float32]:
    """Squares as large as the boxes, at random places that touch none."""
    rows, columns = shape
    windows = []
    for box in boxes:
        left, found = 0.5 * min(box.side, 0.9 * min(shape)), 0
        for _ in range(200):
            x, y = float(rng.uniform(left, columns - left)), float(rng.uniform(left, rows - left))
            if all(abs(x - b.x) > (b.width + box.side) / 2 or abs(y - b.y) > (b.height + box.side) / 2 for b in boxes):
                windows.append((x, y, box.side))
                found += 1
                if found == WINDOWS_PER_BOX:
                    break
    return np.array(windows, np.float32).reshape(-1, 3)


def _jittered(boxes: Sequence[Box], rng: np.random.Generator) -> NDArray[np.float32]:
    spots = [
        (
            b.x + rng.uniform(-0.15, 0.15) * b.width,
            b.y + rng.uniform(-0.15, 0.15) * b.height,
            b.side * rng.uniform(0.75, 1.4),
        )
        for b in boxes
        for _ in range(JITTERS)
    ]
    return np.array(spots, np.float32).reshape(-1, 3)
