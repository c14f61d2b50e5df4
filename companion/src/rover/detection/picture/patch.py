"""What the classifier is told about a spot of a picture that knows neither kelvin nor metres.

Everything is measured in diameters of the spot and in the picture's own spread of grey levels:

- a thermal and an occupancy patch (paper section 3.2.1), and a wider patch of what lies around;
- gradients: how strong they are in each of eight directions, in cells of the patch and of the wider patch;
- circles around the middle (`picture_circles`), and how the spot stands among all spots of the picture.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rover.detection.picture import circles
from rover.detection.picture.maps import PictureMaps, sample

# Side of both patches, of what is shown of occupancy and of the wider one, and of the cells of gradients.
SIDE, SHOWN_SIDE, CELLS = 16, 8, 4
# Widths of the patch and of the wider one, in diameters, and how many levels coarser the latter is sampled.
PATCH, WIDE = 1.5, 3.6
COARSER = 1
DIRECTIONS = 8
_ANGLES = np.arange(DIRECTIONS // 2) * (2.0 * np.pi / DIRECTIONS)
_GRID = ((np.arange(SIDE) - (SIDE - 1) / 2.0) / SIDE).astype(np.float32)
_ROWS, _COLUMNS = (part.ravel() for part in np.meshgrid(_GRID, _GRID, indexing="ij"))
LENGTH = SIDE**2 + 2 * SHOWN_SIDE**2 + 2 * DIRECTIONS * CELLS**2 + circles.NUMBERS

Block = NDArray[np.float32]


def _mirrored(across: int, down: int) -> NDArray[np.intp]:
    """Where a vector's numbers come from when the picture is mirrored along the axes that are -1."""
    index = np.arange(LENGTH)
    begin = 0
    for side in (SIDE, SHOWN_SIDE, SHOWN_SIDE):
        part = index[begin : begin + side * side]
        part[:] = part.reshape(side, side)[::down, ::across].ravel()
        begin += side * side
    rising = np.stack((_ANGLES, _ANGLES + np.pi), axis=1).ravel()
    rises = np.round(np.stack((np.cos(rising), np.sin(rising)), axis=1), 6)
    opposite = [int(np.abs(rises - rise * (across, down)).sum(axis=1).argmin()) for rise in rises]
    for _ in ("patch", "wider patch"):
        part = index[begin : begin + DIRECTIONS * CELLS**2]
        part[:] = part.reshape(DIRECTIONS, CELLS, CELLS)[opposite, ::down, ::across].ravel()
        begin += len(part)
    return index


# The vector of a spot in the picture as it is and in its mirror images (4, LENGTH); gradients to half a pixel of their
# patch. Quarter turns are not among them: pictures that were stretched along one axis look otherwise when turned.
MIRRORED = np.stack([_mirrored(across, down) for across in (1, -1) for down in (1, -1)])


def describe_spots(maps: PictureMaps, spots: Block, reference: Block | None = None) -> Block:
    """Vectors (N, LENGTH) of spots (N, 3) x, y, diameter.

    reference: spots that the picture's own extremes and ranks are taken from, `spots` when not given.
    """
    if not len(spots):
        return np.zeros((0, LENGTH), np.float32)
    numbers, local = circles.describe(maps, spots, reference)
    near, far = _patches(maps, spots, PATCH, 0), _patches(maps, spots, WIDE, COARSER)
    away = np.abs(_pooled(near, SIDE // SHOWN_SIDE)).reshape(len(spots), -1)
    occupied = away > np.maximum(2.0 * local, 0.35 * away.max(axis=1, keepdims=True))
    return np.hstack(
        (
            _normal(near),
            occupied.astype(np.float32),
            _normal(_pooled(far, SIDE // SHOWN_SIDE)),
            _gradients(near),
            _gradients(far),
            numbers,
        )
    )


def _patches(maps: PictureMaps, spots: Block, width: float, coarser: int) -> Block:
    """Brightness (N, SIDE, SIDE) of squares `width` diameters wide, less its median."""
    found = np.zeros((len(spots), SIDE * SIDE), np.float32)
    for level, chosen in maps.by_level(spots, coarser):
        found[chosen] = sample(maps, 1, level, spots[chosen], width * _COLUMNS, width * _ROWS)[0]
    found -= np.median(found[:, ::3], axis=1, keepdims=True)
    return found.reshape(-1, SIDE, SIDE)


def _pooled(patches: Block, factor: int) -> Block:
    """Means over squares of `factor` pixels."""
    half = patches[:, 0::2] + patches[:, 1::2]
    half = (half[:, :, 0::2] + half[:, :, 1::2]) * np.float32(0.25)
    return half if factor == 2 else _pooled(half, factor // 2)


def _normal(patches: Block) -> Block:
    flat = patches.reshape(len(patches), -1)
    normal: Block = flat / (flat.std(axis=1, keepdims=True) + np.float32(1.0))
    return normal


def _gradients(patches: Block) -> Block:
    """How steeply the brightness rises in each direction, per cell, over the patch's own steepness (N, 8·cells)."""
    down, across = np.zeros_like(patches), np.zeros_like(patches)
    down[:, :-1] = patches[:, 1:] - patches[:, :-1]
    across[:, :, :-1] = patches[:, :, 1:] - patches[:, :, :-1]
    parts = []
    for angle in _ANGLES.tolist():
        along = np.float32(np.cos(angle)) * across + np.float32(np.sin(angle)) * down
        rising, plain = (_pooled(part, SIDE // CELLS) for part in (np.maximum(along, 0.0), along))
        parts += [rising, np.maximum(rising - plain, 0.0)]
    found = np.stack(parts, axis=1).reshape(len(patches), -1)
    root: Block = np.sqrt(found / (found.mean(axis=1, keepdims=True) + np.float32(0.2)))
    return root
