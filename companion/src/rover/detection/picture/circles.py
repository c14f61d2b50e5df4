"""Numbers from circles around a spot: no turn of the picture changes them. Part of `picture_patch`."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rover.detection.picture.maps import BANDS, PictureMaps, sample

POINTS = 16
# Circles, in diameters of the spot; from FIRST_AROUND on it is ground.
CIRCLES = (0.0, 0.12, 0.24, 0.34, 0.44, 0.54, 0.66, 0.82, 1.05, 1.35, 1.7)
FIRST_AROUND = 7
_R, _STRENGTHS = len(CIRCLES), 6
NUMBERS = 13 * _R - 8 + 6 + 3 * _STRENGTHS + 1 + BANDS
_ANGLES = np.arange(POINTS) * (2.0 * np.pi / POINTS)
_ROWS = np.outer(CIRCLES, np.sin(_ANGLES)).ravel().astype(np.float32)
_COLUMNS = np.outer(CIRCLES, np.cos(_ANGLES)).ravel().astype(np.float32)
_WAVES = np.stack([np.exp(1j * n * _ANGLES) for n in (1, 2)], axis=1).astype(np.complex64)

Block = NDArray[np.float32]


def describe(maps: PictureMaps, spots: Block, reference: Block | None = None) -> tuple[Block, Block]:
    """Numbers (N, NUMBERS) of spots (N, 3), and the spread (N, 1) of the ground around each, grey levels."""
    found, known = _sample(maps, spots)
    total, mean, beside, spread, ground = _means(found, known)
    waves = np.abs(beside[0] @ _WAVES) / total[..., None]
    around = total[:, FIRST_AROUND:]
    weight = around / around.sum(axis=1, keepdims=True)
    mean = mean - ground[..., None]
    local = np.sqrt((spread[0][:, FIRST_AROUND:] ** 2 * weight).sum(axis=1, keepdims=True)) + 1.0
    unit = np.float32(maps.spread)
    step = np.diff(found[0], axis=1)
    rise, rise_spread = step.mean(axis=2), step.std(axis=2)
    contrast = mean[0]
    peak = np.abs(contrast[:, :4]).mean(axis=1, keepdims=True) + 1.0
    strengths = _strengths(mean, spread)
    others = strengths if reference is None else _strengths_of(maps, reference)
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
            _against(strengths, others),
            np.log(spots[:, 2:3] / np.float32(max(maps.size))),
            np.tile(maps.coarseness, (len(spots), 1)),
        )
    )
    return numbers.astype(np.float32), local.astype(np.float32)


def _sample(maps: PictureMaps, spots: Block) -> tuple[Block, Block]:
    """Circles (3, N, circles, points), and which of them lie in the picture (N, circles, points)."""
    found = np.zeros((3, len(spots), _R * POINTS), np.float32)
    known = np.zeros((len(spots), _R * POINTS), np.float32)
    for level, chosen in maps.by_level(spots, 0):
        found[:, chosen] = sample(maps, 3, level, spots[chosen], _COLUMNS, _ROWS)
        known[chosen] = maps.inside(spots[chosen], _COLUMNS, _ROWS)
    shape = (len(spots), _R, POINTS)
    known = np.where(known > 0.0, np.float32(1.0), np.float32(1e-3)).reshape(shape)
    return found.reshape(3, *shape), known


def _means(found: Block, known: Block) -> tuple[Block, Block, Block, Block, Block]:
    """Points known, mean, what lies beside it, spread, and the ground's mean, of every circle and map."""
    total = known.sum(axis=2)
    mean = (found * known).sum(axis=3) / total
    beside = (found - mean[..., None]) * known
    spread = np.sqrt((beside * beside).sum(axis=3) / total)
    around = total[:, FIRST_AROUND:]
    weight = around / around.sum(axis=1, keepdims=True)
    return total, mean, beside, spread, (mean[:, :, FIRST_AROUND:] * weight).sum(axis=2)


def _strengths(mean: Block, spread: Block) -> Block:
    """How much a spot stands out (N, 6): brightness, over its ring's spread, and signed; textures; evenness."""
    inner = mean[:, :, :4].mean(axis=2)
    ring = spread[0][:, 5:8].mean(axis=1) + 1.0
    even = -np.log((spread[0][:, 1:4].mean(axis=1) + 1.0) / ring)
    bright, *textures = np.abs(inner)
    return np.stack((bright, bright / ring, np.maximum(inner[0], 0.0), *textures, even), axis=1)


def _strengths_of(maps: PictureMaps, spots: Block) -> Block:
    _, mean, _, spread, ground = _means(*_sample(maps, spots))
    return _strengths(mean - ground[..., None], spread)


def _against(strengths: Block, others: Block) -> Block:
    """Strengths beside the strongest of the picture and beside its ninth decile, logarithms; and ranks, 0 the first."""
    least = np.float32(0.05)
    extremes = np.stack((others.max(axis=0), np.quantile(others, 0.9, axis=0)))
    beside = [np.log((np.maximum(strengths, 0.0) + least) / (np.maximum(e, 0.0) + least)) for e in extremes]
    stronger = np.stack(
        [
            len(others) - np.searchsorted(np.sort(others[:, i]), strengths[:, i], side="right")
            for i in range(strengths.shape[1])
        ],
        axis=1,
    )
    ranks = np.log1p(stronger) / np.log1p(len(others))
    return np.hstack((np.clip(np.hstack(beside), -4.0, 4.0), 3.0 * ranks))
