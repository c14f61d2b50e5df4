"""What the classifier is told about a spot of a picture without kelvin: everything in units of the spot's own size
and of the picture's own contrast, on circles around its centre, so that no turn of the picture changes it.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.detection.picture_maps import PictureMaps

SIDE = 16
POINTS = 16
# Circles, in diameters of the spot; from FIRST_AROUND on it is ground.
CIRCLES = (0.0, 0.12, 0.24, 0.34, 0.44, 0.54, 0.66, 0.82, 1.05, 1.35, 1.7)
FIRST_AROUND = 7
# Width of the patches, in diameters; what lies farther out the circles tell.
PATCH = 1.5
_R = len(CIRCLES)
NUMBERS = 13 * _R - 8 + 6 + 8
LENGTH = 2 * SIDE * SIDE + NUMBERS
_ANGLES = np.arange(POINTS) * (2.0 * np.pi / POINTS)
_ROWS = np.outer(CIRCLES, np.sin(_ANGLES)).ravel().astype(np.float32)
_COLUMNS = np.outer(CIRCLES, np.cos(_ANGLES)).ravel().astype(np.float32)
_WAVES = np.stack([np.exp(1j * n * _ANGLES) for n in (1, 2)], axis=1).astype(np.complex64)
_GRID = ((np.arange(SIDE) - (SIDE - 1) / 2.0) / SIDE).astype(np.float32)
_PATCH_ROWS, _PATCH_COLUMNS = (part.ravel() for part in np.meshgrid(_GRID, _GRID, indexing="ij"))

Block = NDArray[np.float32]


def describe_spots(
    maps: PictureMaps, spots: Block, reference: Block | None = None
) -> tuple[Block, Block, Block]:
    """Thermal and occupancy patches (N, 256) and numbers (N, NUMBERS) of spots (N, 3) x, y, diameter.

    reference: spots that the picture's own extremes are taken from, `spots` when not given.
    """
    circles, known, thermal = _sample(maps, spots)
    total = known.sum(axis=2)
    mean = (circles * known).sum(axis=3) / total
    beside = (circles - mean[..., None]) * known
    spread = np.sqrt((beside * beside).sum(axis=3) / total)
    waves = np.abs(beside[0] @ _WAVES) / total[..., None]
    around = total[:, FIRST_AROUND:]
    weight = around / around.sum(axis=1, keepdims=True)
    ground = (mean[:, :, FIRST_AROUND:] * weight).sum(axis=2)
    mean = mean - ground[..., None]
    local = np.sqrt((spread[0][:, FIRST_AROUND:] ** 2 * weight).sum(axis=1, keepdims=True)) + 1.0
    unit = np.float32(maps.spread)
    step = np.diff(circles[0], axis=1)
    rise, rise_spread = step.mean(axis=2), step.std(axis=2)
    contrast = mean[0]
    peak = np.abs(contrast[:, :4]).mean(axis=1, keepdims=True) + 1.0
    extremes = _extremes(mean, spread) if reference is None else _extremes_of(maps, reference)
    numbers = np.hstack(
        (
            np.arcsinh(contrast / unit),
            np.arcsinh(contrast / local),
            np.arcsinh(spread[0][:, 1:] / unit),
            np.log((spread[0][:, 1:] + 1.0) / (local + 1.0)),
            np.arcsinh(waves[:, 1:, 0] / unit),
            np.arcsinh(waves[:, 1:, 1] / unit),
            np.clip(contrast * np.sign(contrast[:, 1:2]) / peak, -3.0, 3.0),
            np.arcsinh(rise / unit),
            np.clip(rise / (rise_spread + 1.0), -8.0, 8.0),
            mean[1],
            spread[1][:, 1:],
            mean[2],
            spread[2][:, 1:],
            np.log(local),
            np.full_like(local, np.log(unit)),
            ground[1][:, None],
            ground[2][:, None],
            np.arcsinh((ground[0][:, None] - maps.median) / unit),
            (total / POINTS).mean(axis=1, keepdims=True),
            _against(mean, spread, extremes),
        )
    ).astype(np.float32)
    thermal = thermal - np.median(thermal, axis=1, keepdims=True)
    away = np.abs(thermal)
    occupied = away > np.maximum(2.0 * local, 0.35 * away.max(axis=1, keepdims=True))
    return (
        _turned(thermal / (thermal.std(axis=1, keepdims=True) + 1.0)),
        _turned(occupied.astype(np.float32)),
        numbers,
    )


def _sample(maps: PictureMaps, spots: Block) -> tuple[Block, Block, Block]:
    """Circles (3, N, circles, points), which of them lie in the picture (N, circles, points), patches (N, 256)."""
    count, levels = len(spots), maps.levels
    # A spot is 10 to 20 pixels wide where it is sampled.
    level_of = np.floor(np.log2(np.maximum(spots[:, 2], 1.0) / maps.step / 10.0))
    level_of = np.clip(level_of, 0, len(levels[0]) - 1).astype(int)
    circles = np.zeros((3, count, _R * POINTS), np.float32)
    known = np.zeros((count, _R * POINTS), np.float32)
    thermal = np.zeros((count, SIDE * SIDE), np.float32)
    for level in np.unique(level_of).tolist():
        chosen = np.nonzero(level_of == level)[0]
        at = _Places(spots[chosen], maps.step * 2.0**level)
        x, y = at.points(_COLUMNS, _ROWS)
        for channel in range(3):
            circles[channel, chosen] = _remap(levels[channel][level], x, y)
        height, width = levels[0][level].shape
        known[chosen] = (x > -1.0) & (x < width) & (y > -1.0) & (y < height)
        thermal[chosen] = _remap(levels[0][level], *at.points(PATCH * _PATCH_COLUMNS, PATCH * _PATCH_ROWS))
    shape = (count, _R, POINTS)
    known = np.where(known > 0.0, np.float32(1.0), np.float32(1e-3)).reshape(shape)
    return circles.reshape(3, *shape), known, thermal


class _Places:
    """Spots in pixels of one level."""

    def __init__(self, spots: Block, step: float) -> None:
        self._x, self._y = (spots[:, axis : axis + 1] / np.float32(step) - np.float32(0.5) for axis in (0, 1))
        self._extent = spots[:, 2:3] / np.float32(step)

    def points(self, columns: Block, rows: Block) -> tuple[Block, Block]:
        """x and y (N, points) of offsets in diameters."""
        return self._x + self._extent * columns, self._y + self._extent * rows


def _remap(picture: Block, x: Block, y: Block) -> Block:
    return cv2.remap(picture, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)


def _strengths(mean: Block, spread: Block) -> Block:
    """How much a spot stands out (N, 4): brightness, brightness over its ring's spread, two textures."""
    inner = mean[:, :, :4].mean(axis=2)
    ring = spread[0][:, 5:8].mean(axis=1) + 1.0
    return np.stack((np.abs(inner[0]), np.abs(inner[0]) / ring, np.abs(inner[1]), np.abs(inner[2])), axis=1)


def _extremes(mean: Block, spread: Block) -> Block:
    strengths = _strengths(mean, spread)
    return np.stack((strengths.max(axis=0), np.quantile(strengths, 0.9, axis=0))) + np.float32(0.05)


def _extremes_of(maps: PictureMaps, reference: Block) -> Block:
    circles, known, _ = _sample(maps, reference)
    total = known.sum(axis=2)
    mean = (circles * known).sum(axis=3) / total
    beside = (circles - mean[..., None]) * known
    spread = np.sqrt((beside * beside).sum(axis=3) / total)
    around = total[:, FIRST_AROUND:]
    weight = around / around.sum(axis=1, keepdims=True)
    ground = (mean[:, :, FIRST_AROUND:] * weight).sum(axis=2)
    return _extremes(mean - ground[..., None], spread)


def _against(mean: Block, spread: Block, extremes: Block) -> Block:
    """Strengths beside the strongest of the picture, and beside its ninth decile (N, 8), logarithms."""
    strengths = _strengths(mean, spread) + np.float32(0.05)
    return np.clip(np.log(np.hstack([strengths / extreme for extreme in extremes])), -4.0, 4.0)


def _turned(patches: Block) -> Block:
    """The mean over the eight turns and mirror images of each patch (N, 256)."""
    square = patches.reshape(-1, SIDE, SIDE)
    square = 0.5 * (square + square.transpose(0, 2, 1))
    square = 0.5 * (square + square[:, ::-1])
    square = 0.5 * (square + square[:, :, ::-1])
    square = 0.5 * (square + square.transpose(0, 2, 1))
    return square.reshape(-1, SIDE * SIDE).astype(np.float32)
