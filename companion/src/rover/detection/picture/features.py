"""What a network trained on photographs sees in a picture: the first eight stages of EfficientNet-Lite0, frozen.

Six mines are too few to learn from what edges, textures and discs are; photographs have taught that. The picture is
shown at three scales, and a candidate is described by what the features are at its middle, within it and beside it.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.detection.model_file import open_model, shipped
from rover.detection.picture.maps import MAX_UNHALVED_PX, PictureMaps
from rover.errors import BadInput

FILE = "picture_features.onnx"
# Numbers of a cell, and pixels from one cell's middle to the next; the first lies on the first pixel.
CHANNELS, STRIDE = 80, 16
# Longest side that is shown at the finest scale, pixels. Small pictures come at video rate.
SIDE_PX, SMALL_SIDE_PX = 320, 240
# For each scale, half the one before it: the radii, in diameters of the spot, at which features are taken.
SCALES: tuple[tuple[float, ...], ...] = ((0.0, 0.45, 1.1), (0.0, 0.45, 1.1), (0.0,))
LENGTH = CHANNELS * sum(len(radii) for radii in SCALES)
# The picture's deviation comes to this, as photographs' does; so many grey levels are no contrast.
DEVIATION, MIN_DEVIATION = 0.5, 4.0
_MIDDLE = np.array((0.5, 0.5, 0.0), np.float32)
_ANGLES = np.arange(8) * (np.pi / 4.0)

Block = NDArray[np.float32]


class Features:
    """The file of features that ships, ready to run. Raises BadInput when it is missing or another one."""

    def __init__(self) -> None:
        file, again = shipped(FILE), "make it anew with python -m tools.train features"
        self._session, self.sha256 = open_model(file, again)
        ends = (*self._session.get_inputs(), *self._session.get_outputs())
        if [each.name for each in ends] != ["grey", "shares", "features"] or ends[-1].shape[1] != CHANNELS:
            raise BadInput(f"{file}: takes or gives other numbers than this version's features; {again}")

    def seen(self, grey: Block, shares: Block) -> Block:
        """(N, CHANNELS): means over the cells of a picture (h, w) of mean 0 and deviation DEVIATION, each cell
        counting for its share (N, cells)."""
        inputs = {"grey": np.ascontiguousarray(grey[None, None], np.float32), "shares": shares}
        found: Block = self._session.run(None, inputs)[0]
        return found

    def describe(self, maps: PictureMaps, spots: Block) -> Block:
        """(N, LENGTH) of spots (N, 3) x, y, diameter, pixels of the picture."""
        parts = []
        for radii, (grey, step) in zip(SCALES, _shown(maps), strict=True):
            # Index of the cell at a place of the picture: pixel k of `grey` has its middle at (k + 0.5) steps.
            places = (spots / np.float32(step) - _MIDDLE) / np.float32(STRIDE)
            shape = cells_of(grey.shape)
            found = self.seen(grey, np.concatenate([_shares(places, radius, shape) for radius in radii]))
            parts += np.split(found, len(radii))
        return np.hstack(parts)


def cells_of(shape: tuple[int, ...]) -> tuple[int, int]:
    """Rows and columns of cells of a picture (h, w)."""
    rows, columns = (-(-side // STRIDE) for side in shape)
    return rows, columns


@lru_cache(maxsize=1)
def shipped_features() -> Features:
    """Loaded once."""
    return Features()


def _shown(maps: PictureMaps) -> Sequence[tuple[Block, float]]:
    """The picture at every scale, and how many of its pixels make one there."""
    width, height = maps.size
    longest = SIDE_PX if max(width, height) > MAX_UNHALVED_PX else SMALL_SIDE_PX
    step = max(maps.step, max(width, height) / longest)
    grey = maps.levels[0][0]
    if step > maps.step:
        grey = _shrunk(grey, maps.step / step)
    mean, deviation = float(grey.mean()), float(grey.std())
    grey = (grey - np.float32(mean)) * np.float32(DEVIATION / (deviation + MIN_DEVIATION))
    shown = [(grey, step)]
    for _ in SCALES[1:]:
        grey, step = _shrunk(grey, 0.5), 2.0 * step
        shown.append((grey, step))
    return shown


def _shrunk(grey: Block, share: float) -> Block:
    size = tuple(max(1, round(side * share)) for side in reversed(grey.shape))
    return np.asarray(cv2.resize(grey, size, interpolation=cv2.INTER_AREA), np.float32)


def _shares(places: Block, radius: float, shape: tuple[int, int]) -> Block:
    """How much each cell counts (N, cells) for spots (N, 3) in cells: bilinear, mean over a circle of this radius in
    diameters. What lies outside counts for the nearest edge."""
    angles = _ANGLES if radius else _ANGLES[:1]
    rows, columns = shape
    shares = np.zeros(len(places) * rows * columns)
    first = np.arange(len(places))[:, None] * (rows * columns)
    across = places[:, :1] + radius * places[:, 2:] * np.cos(angles)
    down = places[:, 1:2] + radius * places[:, 2:] * np.sin(angles)
    u, v = np.clip(across, 0, columns - 1), np.clip(down, 0, rows - 1)
    left, top = np.floor(u).astype(int), np.floor(v).astype(int)
    for column, of_column in ((left, 1.0 - (u - left)), (np.minimum(left + 1, columns - 1), u - left)):
        for row, of_row in ((top, 1.0 - (v - top)), (np.minimum(top + 1, rows - 1), v - top)):
            cell = first + row * columns + column
            shares += np.bincount(cell.ravel(), (of_column * of_row).ravel(), len(shares))
    weights = shares.reshape(len(places), -1) / len(angles)
    return weights.astype(np.float32)
