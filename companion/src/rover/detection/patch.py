"""What the classifier is told about a candidate: two small pictures and a few numbers (paper section 4.2).

[0, 256)    16x16 thermal patch, 2 cm a pixel: contrast against the ground around, divided by its spread
[256, 512)  16x16 occupancy patch: where the contrast stands out of the ground's own spread (section 4.1)
[512, ...)  numbers, see STATISTICS
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.detection.candidates import Candidate
from rover.detection.ground_image import GroundImage

SIDE = 16
PATCH_METRES_PER_PIXEL = 0.02
# Mean contrasts of these rings around the centre, metres.
RINGS = (0.0, 0.02, 0.04, 0.06, 0.08, 0.11, 0.15)
STATISTICS = (
    *(f"ring {a * 100:.0f}-{b * 100:.0f} cm" for a, b in pairwise(RINGS)),
    *(f"spread of ring {a * 100:.0f}-{b * 100:.0f} cm" for a, b in pairwise(RINGS)),
    "highest",
    "lowest",
    "mean gradient",
    "steepest gradient",
    "spread of the ground",
    "occupied share",
    "extent",
    "range",
)
LENGTH = 2 * SIDE * SIDE + len(STATISTICS)
# Numbers that hold kelvin: meaningless in a picture whose scale was stretched.
KELVIN_COLUMNS = tuple(2 * SIDE * SIDE + i for i in range(len(STATISTICS) - 3))

_OFFSETS = ((np.arange(SIDE) - (SIDE - 1) / 2.0) * PATCH_METRES_PER_PIXEL).astype(np.float32)
_DISTANCE = np.hypot(*np.meshgrid(_OFFSETS, _OFFSETS, indexing="ij"))
_RING_WEIGHTS = np.stack([((a <= _DISTANCE) & (b > _DISTANCE)).astype(np.float32).ravel() for a, b in pairwise(RINGS)])
_RING_WEIGHTS /= _RING_WEIGHTS.sum(axis=1, keepdims=True)
_OUTSIDE = (_DISTANCE >= 0.12).ravel()


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
    numbers = np.column_stack(
        (
            np.arcsinh(rings),
            np.arcsinh(ring_spread),
            np.arcsinh(contrast.max(axis=1)),
            np.arcsinh(contrast.min(axis=1)),
            np.arcsinh(slope.mean(axis=1)),
            np.arcsinh(slope.max(axis=1)),
            np.arcsinh(spread[:, 0]),
            occupied.mean(axis=1),
            [candidate.extent for candidate in candidates],
            _range(image, candidates),
        )
    )
    return np.hstack((thermal, occupied, numbers)).astype(np.float32)


def _range(image: GroundImage, candidates: Sequence[Candidate]) -> NDArray[np.float64]:
    """Distance ahead in metres: the farther, the more an upright thing is drawn out."""
    pixels = np.array([(c.row, c.column) for c in candidates])
    return image.to_base(pixels)[:, 0]


def _cut(image: GroundImage, candidates: Sequence[Candidate]) -> NDArray[np.float32]:
    """Patches (N, SIDE, SIDE) in kelvin, centred on the candidates."""
    step = PATCH_METRES_PER_PIXEL / image.metres_per_pixel
    # Each patch pixel stands for a square of ground: smooth by its size, then sample.
    smooth = cv2.blur(image.kelvin, (max(1, round(step)),) * 2) if step > 1.5 else image.kelvin
    offsets = (np.arange(SIDE, dtype=np.float32) - (SIDE - 1) / 2.0) * step
    rows = np.array([c.row for c in candidates], np.float32)[:, None] + offsets
    columns = np.array([c.column for c in candidates], np.float32)[:, None] + offsets
    if step > 1.5:  # an even box lies half a pixel up and left of its anchor
        rows, columns = rows + 0.5, columns + 0.5
    map_y = np.repeat(rows[:, :, None], SIDE, axis=2).reshape(-1, SIDE)
    map_x = np.repeat(columns[:, None, :], SIDE, axis=1).reshape(-1, SIDE)
    cut = cv2.remap(smooth, map_x, map_y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return cut.reshape(-1, SIDE, SIDE)
