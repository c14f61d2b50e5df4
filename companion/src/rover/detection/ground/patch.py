"""What the classifier is told about a candidate: small pictures and a few numbers (paper section 4.2).

[0, 256)    16x16 thermal patch, 2 cm a pixel: contrast against the ground around, divided by its spread
[256, 512)  16x16 occupancy patch: where the contrast stands out of the ground's own spread (section 4.1)
[512, 768)  16x16 wide patch, 4.5 cm a pixel: contrast in kelvin, for deep mines and for what lies around
[768, ...)  numbers, see STATISTICS
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.detection.ground.candidates import Candidate
from rover.detection.ground.image import GroundImage

SIDE = 16
PATCH_METRES_PER_PIXEL = 0.02
# Mean contrasts of these rings around the centre, metres.
RINGS = (0.0, 0.02, 0.04, 0.06, 0.08, 0.11, 0.15)
# Circles around the centre, metres, and the points that are sampled on each: a mine is round, a patch of soil is not.
CIRCLES = (0.0, 0.03, 0.06, 0.09, 0.12, 0.15, 0.18, 0.22, 0.26, 0.30, 0.35)
POINTS = 16
# From this circle on it is ground around rather than a mine.
FIRST_AROUND = 7
# Softening of a circle's samples, metres.
SOFT = 0.03
WIDE_METRES_PER_PIXEL = 0.045
STATISTICS = (
    *(f"ring {a * 100:.0f}-{b * 100:.0f} cm" for a, b in pairwise(RINGS)),
    *(f"spread of ring {a * 100:.0f}-{b * 100:.0f} cm" for a, b in pairwise(RINGS)),
    *(f"circle {r * 100:.0f} cm" for r in CIRCLES),
    *(f"spread of circle {r * 100:.0f} cm" for r in CIRCLES[1:]),
    *(f"slope across circle {r * 100:.0f} cm" for r in CIRCLES[1:]),
    *(f"elongation of circle {r * 100:.0f} cm" for r in CIRCLES[1:]),
    *(f"profile at {r * 100:.0f} cm" for r in CIRCLES),
    "valid ground around",
    "highest",
    "lowest",
    "mean gradient",
    "steepest gradient",
    "spread of the ground",
    "occupied share",
    "extent",
    "strength",
    "range",
)
LENGTH = 3 * SIDE * SIDE + len(STATISTICS)

_OFFSETS = ((np.arange(SIDE) - (SIDE - 1) / 2.0) * PATCH_METRES_PER_PIXEL).astype(np.float32)
_DISTANCE = np.hypot(*np.meshgrid(_OFFSETS, _OFFSETS, indexing="ij"))
_RING_WEIGHTS = np.stack([((a <= _DISTANCE) & (b > _DISTANCE)).astype(np.float32).ravel() for a, b in pairwise(RINGS)])
_RING_WEIGHTS /= _RING_WEIGHTS.sum(axis=1, keepdims=True)
_OUTSIDE = (_DISTANCE >= 0.12).ravel()
_ANGLES = np.arange(POINTS) * (2.0 * np.pi / POINTS)
_CIRCLE_ROWS = np.outer(CIRCLES, np.sin(_ANGLES)).astype(np.float32)
_CIRCLE_COLUMNS = np.outer(CIRCLES, np.cos(_ANGLES)).astype(np.float32)
_WAVES = np.stack([np.exp(1j * n * _ANGLES) for n in (1, 2)], axis=1).astype(np.complex64)


def describe(image: GroundImage, candidates: Sequence[Candidate]) -> NDArray[np.float32]:
    """One vector per candidate, (N, LENGTH) float32. Contrasts in kelvin are squashed by asinh."""
    if not candidates:
        return np.zeros((0, LENGTH), np.float32)
    patches = _cut(image, candidates)
    flat = patches.reshape(len(candidates), -1)
    # The ground is what lies around: its median, and its spread from the median deviation.
    ground = np.median(flat[:, _OUTSIDE], axis=1, keepdims=True)
    contrast = flat - ground
    spread = 1.4826 * np.median(np.abs(contrast[:, _OUTSIDE]), axis=1, keepdims=True) + 0.05
    peak = np.abs(contrast).max(axis=1, keepdims=True)
    occupied = (np.abs(contrast) > np.maximum(3.0 * spread, 0.35 * peak)).astype(np.float32)
    thermal = contrast / np.maximum(contrast.std(axis=1, keepdims=True), 0.05)
    rings = contrast @ _RING_WEIGHTS.T
    ring_spread = np.sqrt(np.maximum((contrast**2) @ _RING_WEIGHTS.T - rings**2, 0.0))
    picture = contrast.reshape(-1, SIDE, SIDE)
    along = np.diff(picture, axis=1)[:, :, :-1]
    across = np.diff(picture, axis=2)[:, :-1, :]
    slope = np.hypot(along, across).reshape(len(candidates), -1)
    wide, circles = _surroundings(image, candidates)
    numbers = np.column_stack(
        (
            np.arcsinh(rings),
            np.arcsinh(ring_spread),
            circles,
            np.arcsinh(contrast.max(axis=1)),
            np.arcsinh(contrast.min(axis=1)),
            np.arcsinh(slope.mean(axis=1)),
            np.arcsinh(slope.max(axis=1)),
            np.arcsinh(spread[:, 0]),
            occupied.mean(axis=1),
            [candidate.extent for candidate in candidates],
            np.arcsinh([candidate.strength for candidate in candidates]),
            _range(image, candidates),
        )
    )
    return np.hstack((thermal, occupied, wide, numbers)).astype(np.float32)


def _range(image: GroundImage, candidates: Sequence[Candidate]) -> NDArray[np.float64]:
    """Distance ahead in metres: the farther, the more an upright thing is drawn out."""
    pixels = np.array([(c.row, c.column) for c in candidates])
    return image.to_base(pixels)[:, 0]


def _cut(image: GroundImage, candidates: Sequence[Candidate]) -> NDArray[np.float32]:
    """Patches (N, SIDE, SIDE) in kelvin, centred on the candidates."""
    step = PATCH_METRES_PER_PIXEL / image.metres_per_pixel
    # Each patch pixel stands for a square of ground: smooth by its size, then sample.
    smooth = _soften(image.kelvin, step)
    offsets = (np.arange(SIDE, dtype=np.float32) - (SIDE - 1) / 2.0) * step
    rows, columns = np.meshgrid(offsets, offsets, indexing="ij")
    return _sample(smooth, candidates, rows, columns, step).reshape(-1, SIDE, SIDE)


def _surroundings(
    image: GroundImage, candidates: Sequence[Candidate]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Wide patches (N, SIDE²) and the numbers of the circles (N, ...), contrasts in squashed kelvin.

    Where the picture ends nothing is known: the wide patch is zero there, and the circles leave it out.
    """
    count = len(candidates)
    # Outside the picture this is zero: there the image holds its median.
    plain = image.kelvin - np.float32(image.median)
    mask, shape = image.valid.tobytes(), image.valid.shape

    step = SOFT / image.metres_per_pixel
    soft, share = _soften(plain, step), _share(mask, shape, step)
    rows, columns = _CIRCLE_ROWS / image.metres_per_pixel, _CIRCLE_COLUMNS / image.metres_per_pixel
    known = _sample(share, candidates, rows, columns, step, outside=0.0).reshape(count, len(CIRCLES), POINTS)
    value = _sample(soft, candidates, rows, columns, step, outside=0.0).reshape(known.shape)
    value /= np.maximum(known, 0.05)
    known = np.where(known > 0.5, np.float32(1.0), np.float32(1e-4))
    total = known.sum(axis=2)
    mean = (value * known).sum(axis=2) / total
    around = total[:, FIRST_AROUND:]
    ground = ((mean[:, FIRST_AROUND:] * around).sum(axis=1) / around.sum(axis=1))[:, None]
    beside = (value - mean[:, :, None]) * known
    spread = np.sqrt((beside**2).sum(axis=2) / total)[:, 1:]
    waves = np.abs(beside[:, 1:] @ _WAVES) / total[:, 1:, None]
    mean = mean - ground
    height = np.abs(mean[:, :3]).mean(axis=1, keepdims=True) + 0.05
    numbers = np.hstack(
        (
            np.arcsinh(2.0 * mean),
            np.arcsinh(2.0 * spread),
            np.arcsinh(2.0 * waves[:, :, 0]),
            np.arcsinh(2.0 * waves[:, :, 1]),
            np.clip(mean * np.sign(mean[:, :1]) / height, -3.0, 3.0),
            (around > POINTS / 2).mean(axis=1, keepdims=True),
        )
    )

    step = WIDE_METRES_PER_PIXEL / image.metres_per_pixel
    soft, share = _soften(plain, step), _share(mask, shape, step)
    offsets = (np.arange(SIDE, dtype=np.float32) - (SIDE - 1) / 2.0) * step
    rows, columns = np.meshgrid(offsets, offsets, indexing="ij")
    part = _sample(share, candidates, rows, columns, step, outside=0.0)
    wide = _sample(soft, candidates, rows, columns, step, outside=0.0) / np.maximum(part, 0.05) - ground
    return np.where(part > 0.5, np.arcsinh(2.0 * wide), 0.0), numbers


@lru_cache(maxsize=8)
def _share(mask: bytes, shape: tuple[int, int], step: float) -> NDArray[np.float32]:
    """How much of the square of `step` pixels around each pixel lies in the picture; masks repeat."""
    return _soften(np.frombuffer(mask, np.bool_).reshape(shape).astype(np.float32), step)


def _soften(picture: NDArray[np.float32], step: float) -> NDArray[np.float32]:
    """Means over squares of `step` pixels."""
    if step <= 1.5:
        return picture
    side = round(step)
    return np.asarray(cv2.blur(picture, (side, side)), np.float32)


def _sample(
    picture: NDArray[np.float32],
    candidates: Sequence[Candidate],
    rows: NDArray[np.float32],
    columns: NDArray[np.float32],
    step: float,
    outside: float | None = None,
) -> NDArray[np.float32]:
    """Values (N, points) of a softened picture at offsets from the candidates, pixels; edges are drawn out."""
    # An even box lies half a pixel up and left of its anchor.
    shift = 0.5 if step > 1.5 and round(step) % 2 == 0 else 0.0
    centres = np.array([(c.row, c.column) for c in candidates], np.float32) + np.float32(shift)
    map_y = centres[:, :1] + rows.reshape(1, -1).astype(np.float32)
    map_x = centres[:, 1:] + columns.reshape(1, -1).astype(np.float32)
    border = cv2.BORDER_REPLICATE if outside is None else cv2.BORDER_CONSTANT
    values = cv2.remap(picture, map_x, map_y, cv2.INTER_LINEAR, borderMode=border, borderValue=outside or 0.0)
    return np.asarray(values, np.float32)
