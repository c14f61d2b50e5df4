"""Which cells around a spot differ from the ground beside it: the occupancy patch (paper section 4.1)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rover.detection.picture.maps import PictureMaps, sample

# Cells along a side, samples along a cell, and the patch's width in diameters of the spot.
SIDE, FINER, WIDTH = 8, 2, 1.5
LENGTH = SIDE * SIDE
# Circles of ground, in diameters of the spot, and points on each.
CIRCLES, POINTS = (0.82, 1.05, 1.35, 1.7), 16
# A cell is occupied where it stands out by so many times the ground's spread, and this share of the strongest cell.
SPREADS, SHARE = 2.0, 0.35
_GRID = ((np.arange(SIDE * FINER) - (SIDE * FINER - 1) / 2.0) * (WIDTH / (SIDE * FINER))).astype(np.float32)
_PATCH = tuple(part.ravel() for part in np.meshgrid(_GRID, _GRID))
_ANGLES = np.arange(POINTS) * (2.0 * np.pi / POINTS)
_AROUND = tuple(np.outer(CIRCLES, way(_ANGLES)).ravel().astype(np.float32) for way in (np.cos, np.sin))

Block = NDArray[np.float32]


def occupancy(maps: PictureMaps, spots: Block) -> Block:
    """1 where a cell is occupied, else 0 (N, LENGTH), of spots (N, 3) x, y, diameter in pixels of the picture."""
    patches = np.zeros((len(spots), len(_PATCH[0])), np.float32)
    around = np.zeros((len(spots), len(_AROUND[0])), np.float32)
    for level, chosen in maps.by_level(spots):
        patches[chosen] = sample(maps, level, spots[chosen], *_PATCH)
        around[chosen] = sample(maps, level, spots[chosen], *_AROUND)
    patches -= np.median(patches[:, ::3], axis=1, keepdims=True)
    away = np.abs(patches.reshape(-1, SIDE, FINER, SIDE, FINER).mean(axis=(2, 4))).reshape(-1, LENGTH)
    variance = around.reshape(-1, len(CIRCLES), POINTS).var(axis=2).mean(axis=1, keepdims=True)
    occupied = away > np.maximum(SPREADS * (np.sqrt(variance) + 1.0), SHARE * away.max(axis=1, keepdims=True))
    return np.asarray(occupied, np.float32)
