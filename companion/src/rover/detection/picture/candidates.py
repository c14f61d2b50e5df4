"""Spots of a picture whose scale is not known, or not well: blobs of every size, in brightness and in texture.

Recall is what counts: the strongest few of every size, sign and map are looked at, whatever stands out elsewhere.
"""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.detection.picture.maps import MAX_UNHALVED_PX, Map, PictureMaps

# Diameters, as shares of the picture's longer side, and the ratio of one to the next.
MIN_SIZE_SHARE, MAX_SIZE_SHARE, RATIO = 0.026, 0.66, 2.0 ** (1.0 / 3.0)
# The same ratio for small pictures, which come at video rate: their surround is the next centre.
SMALL_RATIO = 2.0 ** (2.0 / 3.0)
# A disc of diameter d answers most at sigma = d / 2.8; the surround is so much wider.
DIAMETER, SURROUND = 2.8, 2.0 ** (2.0 / 3.0)
# Blobs kept of each size, by (map, sign). Most mines that are hardly brighter than the grass measure MIDDLE_SIZES,
# shares of the longer side, in pictures from below 4 m; there the strongest few are often grass.
MIDDLE_SIZES = (0.056, 0.182)
QUOTAS = {(0, 1): 3, (0, -1): 2, (1, 1): 2, (1, -1): 1, (2, 1): 1, (2, -1): 1}
MIDDLE_QUOTAS = {(0, 1): 16, (0, -1): 8, (1, 1): 6, (1, -1): 2, (2, 1): 1, (2, -1): 3}
# Candidates of one size whose centres are nearer than this share of it are one.
NEAR = 0.2
# Weaker answers are no spots, grey levels.
MIN_ANSWER = np.float32(1e-3)
# What a mine may measure on the ground, metres, where the scale is told and the picture shows this much of it.
MINE_METRES = (0.06, 1.2)
TRUSTED_METRES = 1.2

Spots = NDArray[np.float32]


def find_spots(maps: PictureMaps, metres_per_pixel: float | None = None) -> Spots:
    """Candidates (N, 3): x, y of the centre and diameter, in pixels of the picture; deterministic order."""
    longer = max(maps.size)
    low, high = MIN_SIZE_SHARE * longer, MAX_SIZE_SHARE * longer
    if metres_per_pixel is not None and longer * metres_per_pixel >= TRUSTED_METRES:
        low, high = max(low, MINE_METRES[0] / metres_per_pixel), min(high, MINE_METRES[1] / metres_per_pixel)
    ratio = RATIO if longer > MAX_UNHALVED_PX else SMALL_RATIO
    steps = np.arange(round(np.log(MAX_SIZE_SHARE / MIN_SIZE_SHARE) / np.log(ratio)) + 1)
    extents = [e for e in (MIN_SIZE_SHARE * longer * ratio**steps).tolist() if low / ratio <= e <= high * ratio]
    found: list[Spots] = []
    # Small pictures come at video rate, and their fine texture is mostly noise.
    answers = [_answers(maps, channel, extents) for channel in range(3 if longer > MAX_UNHALVED_PX else 2)]
    for index, extent in enumerate(extents):
        here: list[tuple[float, float]] = []
        is_middle = longer > MAX_UNHALVED_PX and MIDDLE_SIZES[0] <= extent / longer < MIDDLE_SIZES[1]
        quotas = MIDDLE_QUOTAS if is_middle else QUOTAS
        for (channel, sign), most in quotas.items():
            if channel >= len(answers):
                continue
            answer, level = answers[channel][index]
            here += [
                (maps.from_level(x, level), maps.from_level(y, level))
                for x, y in _peaks(answer, sign, extent / (maps.step * 2.0**level), most)
            ]
        found.append(np.array([(x, y, extent) for x, y in _apart(here, NEAR * extent)], np.float32).reshape(-1, 3))
    return np.concatenate(found) if found else np.zeros((0, 3), np.float32)


def _answers(maps: PictureMaps, channel: int, extents: list[float]) -> list[tuple[Map, int]]:
    """Difference of Gaussians of every size, and its level."""
    levels = maps.levels[channel]
    blurred: dict[tuple[int, int], Map] = {}
    answers = []
    for extent in extents:
        sigma = extent / maps.step / DIAMETER
        # Sigma between 1.1 and 2.2 pixels of its level: cheap, and exact enough.
        level = int(np.clip(np.floor(np.log2(sigma / 1.1)), 0, len(levels) - 1))
        centre, around = (_blur(levels[level], sigma * ratio / 2.0**level, blurred, level) for ratio in (1.0, SURROUND))
        answers.append((centre - around, level))
    return answers


def _blur(picture: Map, sigma: float, known: dict[tuple[int, int], Map], level: int) -> Map:
    key = (level, round(sigma * 1000.0))
    if key not in known:
        blurred = cv2.GaussianBlur(picture, (0, 0), sigma, borderType=cv2.BORDER_REFLECT_101)
        known[key] = np.asarray(blurred, np.float32)
    return known[key]


def _apart(points: list[tuple[float, float]], distance: float) -> list[tuple[float, float]]:
    """The points in order, without those that lie nearer than this to one before them that stays."""
    if not points:
        return points
    x, y = np.array(points).T
    near = (x[:, None] - x) ** 2 + (y[:, None] - y) ** 2 < distance**2
    return [points[index] for index in first_of_each(near)]


def first_of_each(same: NDArray[np.bool_], most: int | None = None) -> list[int]:
    """Numbers of those that stay, at most so many: none is the same (N, N) as one before it that stays."""
    free = np.ones(len(same), bool)
    kept: list[int] = []
    for index in range(len(same)):
        if free[index]:
            kept.append(index)
            if len(kept) == most:
                break
            free &= ~same[index]
    return kept


def _peaks(answer: Map, sign: int, extent: float, most: int) -> list[tuple[float, float]]:
    """(x, y) of the strongest local maxima above zero, of minima below it where the sign is -1."""
    around = _square(2 * max(1, round(0.25 * extent)) + 1)
    if sign > 0:
        peak = (answer >= cv2.dilate(answer, around)) & (answer > MIN_ANSWER)
    else:
        peak = (answer <= cv2.erode(answer, around)) & (answer < -MIN_ANSWER)
    flat = np.flatnonzero(peak)
    if len(flat) > most:
        flat = flat[np.argsort(-sign * answer.flat[flat], kind="stable")[:most]]
    columns = answer.shape[1]
    return [(index % columns, index // columns) for index in flat.tolist()]


@lru_cache(maxsize=64)
def _square(side: int) -> NDArray[np.uint8]:
    return np.ones((side, side), np.uint8)
