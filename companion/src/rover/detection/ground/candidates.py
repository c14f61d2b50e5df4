"""Spots worth a classifier's look: blobs warmer or colder than the ground around them, 6 to 40 cm wide.

Recall comes first here; the classifier throws out what is only soil. Soil has more contrast at small scales than at
large ones: a blob's strength is its contrast in units of what the ground of this picture has at the same scale, so
that a deep mine, wide and weak, is not lost among small strong spots.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.detection.ground.image import MAX_MEDIAN_PIXELS, GroundImage

# Widths of the Gaussians, metres. An answer is the mean within one minus the mean within the next but one; a disc of
# diameter d answers most where the first is d / 2.8.
WIDTHS = (0.025, 0.040, 0.0625, 0.100, 0.156)
SCALES = len(WIDTHS) - 2
EXTENT_PER_WIDTH = 2.8
# Candidates of one picture.
MAX_CANDIDATES = 16
# What the ground of a picture has at least, kelvin: the camera's noise. And the weakest answer that is looked at, in
# robust standard deviations of the ground's answers at that scale.
MIN_GROUND_SPREAD = 0.03
MIN_STRENGTH = 1.5
# Candidates nearer to each other than this, metres, are one.
SPACING = 0.06
# Candidates whose centre has less than this of valid ground around it, metres, are left out.
EDGE = 0.05
# Pixels of at least this size, metres, are fine enough for the narrowest Gaussian.
WORKING = 0.014


@dataclass(frozen=True)
class Candidate:
    """A blob: centre as (row, column) pixels of the ground image, diameter in metres, answer in kelvin (signed).

    strength: the answer over the spread of the ground's answers at that scale, positive.
    """

    row: float
    column: float
    extent: float
    answer: float
    strength: float = 0.0


class _Peak(NamedTuple):
    """A local extreme of one scale: in units of the ground's answers, where, of which width, in which answers."""

    strength: float
    row: int
    column: int
    width: float
    answer: NDArray[np.float32]


def find_candidates(image: GroundImage, most: int = MAX_CANDIDATES) -> list[Candidate]:
    """Blobs, strongest first; at most `most`."""
    shape = image.kelvin.shape
    halved = image.metres_per_pixel < WORKING and min(shape) > 1
    plain = image.kelvin - np.float32(image.median)
    if halved:
        plain = _half(plain)
    scale = image.metres_per_pixel * (2 if halved else 1)
    shares, around = _ground(image.valid.tobytes(), shape, halved, scale)
    means = [blurred / share for blurred, share in zip(_ladder(plain, scale), shares, strict=True)]
    found: list[_Peak] = []
    for number in range(SCALES):
        found += _peaks(means[number] - means[number + 2], around, WIDTHS[number], scale, most)
    found.sort(key=lambda peak: -peak.strength)
    kept = [_candidate(peak) for peak in _thin(found, SPACING / scale, most)]
    if not halved:
        return kept
    return [Candidate(2 * c.row + 0.5, 2 * c.column + 0.5, c.extent, c.answer, c.strength) for c in kept]


@lru_cache(maxsize=8)
def _ground(
    mask: bytes, shape: tuple[int, int], halved: bool, scale: float
) -> tuple[list[NDArray[np.float32]], NDArray[np.bool_]]:
    """How much of each Gaussian lies on valid ground, and where a candidate's centre may lie. Masks repeat."""
    valid = np.frombuffer(mask, np.bool_).reshape(shape).astype(np.float32)
    if halved:
        valid = _half(valid)
    shares = [np.maximum(share, np.float32(0.05)) for share in _ladder(valid, scale)]
    reach = max(1, round(EDGE / scale))
    whole = np.pad((valid > 0.99).astype(np.uint8), 1)
    around = cv2.erode(whole, np.ones((2 * reach + 1,) * 2, np.uint8), borderValue=0)
    return shares, around[1:-1, 1:-1].astype(bool)


def _half(picture: NDArray[np.float32]) -> NDArray[np.float32]:
    """Means over squares of two by two pixels; an odd last row or column is left out."""
    rows, columns = picture.shape[0] // 2, picture.shape[1] // 2
    even = picture[: 2 * rows, : 2 * columns]
    return np.asarray(cv2.resize(even, (columns, rows), interpolation=cv2.INTER_AREA), np.float32)


def _ladder(picture: NDArray[np.float32], scale: float) -> list[NDArray[np.float32]]:
    """The picture, zero outside, under each Gaussian of WIDTHS: each is made from the one before."""
    steps = []
    before = 0.0
    for width in WIDTHS:
        sigma = math.sqrt(width**2 - before**2) / scale
        blurred = cv2.GaussianBlur(picture, (0, 0), sigma, borderType=cv2.BORDER_CONSTANT)
        picture = np.asarray(blurred, np.float32)
        steps.append(picture)
        before = width
    return steps


def _peaks(
    answer: NDArray[np.float32], around: NDArray[np.bool_], width: float, scale: float, most: int
) -> list[_Peak]:
    """The strongest local extremes of one scale."""
    size = np.abs(answer)
    ground = size[around]
    # The median of so many hardly depends on every one of them.
    some = ground[:: 1 + len(ground) // MAX_MEDIAN_PIXELS]
    spread = max(1.4826 * float(np.median(some)), MIN_GROUND_SPREAD) if len(some) else MIN_GROUND_SPREAD
    reach = 2 * max(1, round(0.7 * width / scale)) + 1
    peak = (size >= cv2.dilate(size, np.ones((reach, reach), np.uint8))) & around & (size >= MIN_STRENGTH * spread)
    flat = np.flatnonzero(peak)
    flat = flat[np.argsort(-size.flat[flat], kind="stable")[:most]]
    rows, columns = np.unravel_index(flat, size.shape)
    strengths = (size.flat[flat] / np.float32(spread)).tolist()
    return [_Peak(*peak, width, answer) for peak in zip(strengths, rows.tolist(), columns.tolist(), strict=True)]


def _candidate(peak: _Peak) -> Candidate:
    size = np.abs(peak.answer[max(peak.row - 1, 0) : peak.row + 2, max(peak.column - 1, 0) : peak.column + 2])
    row, column = min(peak.row, 1), min(peak.column, 1)
    return Candidate(
        peak.row + _vertex(size[:, column].tolist(), row),
        peak.column + _vertex(size[row].tolist(), column),
        EXTENT_PER_WIDTH * peak.width,
        float(peak.answer[peak.row, peak.column]),
        peak.strength,
    )


def _vertex(values: list[float], at: int) -> float:
    """How far from `at` the peak of three samples lies: vertex of the parabola through them; 0 at the border."""
    if at != 1 or len(values) != 3:
        return 0.0
    before, here, after = values
    bend = before - 2.0 * here + after
    return 0.0 if bend >= -1e-9 else max(-0.5, min(0.5, 0.5 * (before - after) / bend))


def _thin(peaks: list[_Peak], spacing: float, most: int) -> list[_Peak]:
    """The strongest of each group of neighbours."""
    kept: list[_Peak] = []
    for peak in peaks:
        if len(kept) == most:
            break
        if all((peak.row - o.row) ** 2 + (peak.column - o.column) ** 2 >= spacing**2 for o in kept):
            kept.append(peak)
    return kept
