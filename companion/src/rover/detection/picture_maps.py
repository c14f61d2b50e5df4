"""A picture without kelvin, seen at many scales: its brightness, and how rough it is.

A mine under cut turf is a spot of bare soil, and on a picture whose contrast was stretched or sharpened that shows
in the texture where it hardly shows in the brightness. So blobs are looked for in three maps: brightness, the
logarithm of its energy at a few pixels, and the same at one pixel.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

Map = NDArray[np.float32]

# Pictures with a longer side than this, pixels, are halved before anything else.
FULL_SIZE = 400
# Larger pictures are shrunk to this first.
LARGEST = 640
# Grey levels that two pixels differ by in any case: the energy of less is noise.
FLOOR = 1.0
LEAST_SPREAD = 2.0
SMALLEST_LEVEL = 24
CHANNELS = ("brightness", "texture", "fine texture")


@dataclass(frozen=True, eq=False)
class PictureMaps:
    """levels[channel][k]: the map at `step`·2^k pixels of the picture per pixel. median, spread: of the brightness."""

    levels: tuple[tuple[Map, ...], ...]
    step: float
    median: float
    spread: float
    size: tuple[int, int]


def picture_maps(grey: Map) -> PictureMaps:
    """The maps of a picture (h, w) in grey levels 0 to 255."""
    height, width = grey.shape
    shrink = max(1.0, max(height, width) / LARGEST)
    if shrink > 1.0:
        grey = cv2.resize(grey, (round(width / shrink), round(height / shrink)), interpolation=cv2.INTER_AREA)
    half = 2.0 if max(grey.shape) > FULL_SIZE else 1.0
    size = (round(grey.shape[1] / half), round(grey.shape[0] / half))
    base = cv2.resize(grey, size, interpolation=cv2.INTER_AREA) if half > 1.0 else grey
    coarse = base - cv2.GaussianBlur(base, (0, 0), 2.0)
    fine = grey - cv2.blur(grey, (3, 3))
    energies = (
        cv2.GaussianBlur(coarse * coarse, (0, 0), 2.0),
        cv2.blur(cv2.resize(fine * fine, size, interpolation=cv2.INTER_AREA), (5, 5)),
    )
    rough = [0.5 * cv2.log(np.maximum(energy, 0.0) + np.float32(FLOOR)) for energy in energies]
    few = base[::2, ::2]
    median = float(np.median(few))
    spread = 1.4826 * float(np.median(np.abs(few - median)))
    return PictureMaps(
        tuple(_pyramid(channel) for channel in (base, *rough)),
        half * shrink,
        median,
        max(spread, LEAST_SPREAD),
        (width, height),
    )


def _pyramid(base: Map) -> tuple[Map, ...]:
    levels = [base]
    while min(levels[-1].shape) >= 2 * SMALLEST_LEVEL:
        levels.append(cv2.pyrDown(levels[-1]))
    return tuple(levels)
