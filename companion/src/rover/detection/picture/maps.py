"""A picture without kelvin, seen at many scales: its brightness, and how rough it is.

A mine under cut turf is a spot of bare soil, and on a picture whose contrast was stretched or sharpened that shows
in the texture where it hardly shows in the brightness. So blobs are looked for in three maps: brightness, the
logarithm of its energy at a few pixels, and the same at one pixel.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

Map = NDArray[np.float32]

# Pictures with a longer side than this, pixels, are halved before anything else.
MAX_UNHALVED_PX = 400
# Larger pictures are shrunk to this first.
MAX_SIDE_PX = 640
# Grey levels that two pixels differ by in any case: the energy of less is noise.
FLOOR = 1.0
MIN_LEVEL_PX = 24


@dataclass(frozen=True, eq=False)
class PictureMaps:
    """levels[channel][k]: the map at `step`·2^k pixels of the picture per pixel. size: (width, height) of the picture.

    Pixel i of level k lies over pixel i·2^k of level 0: a level keeps every other pixel of the one below it.
    """

    levels: tuple[tuple[Map, ...], ...]
    step: float
    size: tuple[int, int]

    def to_level(self, place: Map, level: int) -> Map:
        """Coordinates in the picture, its first pixel from 0 to 1, to indices of pixels of a level."""
        index: Map = (place / np.float32(self.step) - np.float32(0.5)) / np.float32(2.0**level)
        return index

    def by_level(self, spots: Map) -> Iterator[tuple[int, NDArray[np.intp]]]:
        """Levels and the spots (N, 3) that are sampled there, 10 to 20 pixels wide."""
        level = np.floor(np.log2(np.maximum(spots[:, 2], 1.0) / self.step / 10.0))
        level = np.clip(level, 0, len(self.levels[0]) - 1).astype(int)
        for each in np.unique(level).tolist():
            yield each, np.nonzero(level == each)[0]

    def from_level(self, index: float, level: int) -> float:
        """The inverse, of one index."""
        return (index * 2.0**level + 0.5) * self.step


def picture_maps(grey: Map) -> PictureMaps:
    """The maps of a picture (h, w) in grey levels 0 to 255."""
    height, width = grey.shape
    shrink = max(1.0, max(height, width) / MAX_SIDE_PX)
    if shrink > 1.0:
        grey = _shrunk(grey, (round(width / shrink), round(height / shrink)))
    half = 2.0 if max(grey.shape) > MAX_UNHALVED_PX else 1.0
    size = (round(grey.shape[1] / half), round(grey.shape[0] / half))
    base = _shrunk(grey, size) if half > 1.0 else grey
    # In place where it can be: large arrays cost more to fetch than to fill.
    coarse = _smooth(_squared_difference(base, _smooth(base)))
    fine = _squared_difference(grey, _mean(grey, 3))
    fine = _mean(_shrunk(fine, size) if half > 1.0 else fine, 5)
    rough = [_half_logarithm(energy) for energy in (coarse, fine)]
    levels = tuple(_pyramid(channel) for channel in (base, *rough))
    return PictureMaps(levels, half * shrink, (width, height))


def _shrunk(picture: Map, size: tuple[int, int]) -> Map:
    return np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), np.float32)


def _smooth(picture: Map) -> Map:
    return np.asarray(cv2.GaussianBlur(picture, (0, 0), 2.0), np.float32)


def _mean(picture: Map, side: int) -> Map:
    return np.asarray(cv2.blur(picture, (side, side)), np.float32)


def _squared_difference(picture: Map, other: Map) -> Map:
    """(picture - other)², in the place of `other`."""
    np.subtract(picture, other, out=other)
    return np.multiply(other, other, out=other)


def _half_logarithm(energy: Map) -> Map:
    """Of an energy and FLOOR, in the place of the energy."""
    np.maximum(energy, 0.0, out=energy)
    energy += np.float32(FLOOR)
    cv2.log(energy, energy)
    energy *= np.float32(0.5)
    return energy


def _pyramid(base: Map) -> tuple[Map, ...]:
    levels = [base]
    while min(levels[-1].shape) >= 2 * MIN_LEVEL_PX:
        levels.append(np.asarray(cv2.pyrDown(levels[-1]), np.float32))
    return tuple(levels)


def sample(maps: PictureMaps, level: int, spots: Map, columns: Map, rows: Map) -> Map:
    """Brightness (N, points) at one level, at offsets (points,) in diameters from spots (N, 3); edges are drawn out."""
    x, y = (maps.to_level(spots[:, i : i + 1] + spots[:, 2:3] * part, level) for i, part in enumerate((columns, rows)))
    fixed, parts = cv2.convertMaps(x, y, cv2.CV_16SC2)
    found = cv2.remap(maps.levels[0][level], fixed, parts, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(found, np.float32)
