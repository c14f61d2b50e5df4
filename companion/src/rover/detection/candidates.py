"""Spots worth a classifier's look: blobs warmer or colder than the ground around them, 6 to 40 cm wide.

Recall comes first here; the classifier throws out what is only soil.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.detection.ground_image import GroundImage

# Scales of the difference of Gaussians, metres: a disc of diameter d answers most at sigma = d / 2.8.
SIGMAS = (0.022, 0.040, 0.070, 0.120)
# Surround over centre.
RATIO = 1.6
# Candidates of one picture.
MOST = 16
# The weakest answer that is looked at, kelvin, and in robust standard deviations of the answer at that scale.
LEAST_KELVIN = 0.06
LEAST_SIGMAS = 1.0
# Candidates nearer to each other than this, metres, are one.
SPACING = 0.06
# Candidates whose centre has less than this of valid ground around it, metres, are left out.
EDGE = 0.05


@dataclass(frozen=True)
class Candidate:
    """A blob: centre as (row, column) pixels of the ground image, diameter in metres, answer in kelvin (signed)."""

    row: float
    column: float
    extent: float
    answer: float


def find_candidates(image: GroundImage, most: int = MOST) -> list[Candidate]:
    """Blobs, strongest first; at most `most`."""
    scale = image.metres_per_pixel
    valid = image.valid
    around = cv2.erode(
        np.pad(valid.astype(np.uint8), 1), np.ones((2 * round(EDGE / scale) + 1,) * 2, np.uint8), borderValue=0
    )[1:-1, 1:-1].astype(bool)
    plain = image.kelvin - np.float32(image.median)
    found: list[tuple[float, Candidate]] = []
    for sigma in SIGMAS:
        answer = _difference(plain, valid, sigma / scale)
        found += _peaks(answer, around, sigma, scale, most)
    found.sort(key=lambda pair: -pair[0])
    return _thin([candidate for _, candidate in found], SPACING / scale, most)


def _difference(plain: NDArray[np.float32], valid: NDArray[np.bool_], sigma: float) -> NDArray[np.float32]:
    """Centre minus surround, each a mean over valid ground only; at half resolution for wide scales."""
    if sigma > 3.0:
        size = (plain.shape[1] // 2, plain.shape[0] // 2)
        small = cv2.resize(plain, size, interpolation=cv2.INTER_AREA)
        mask = cv2.resize(valid.astype(np.uint8), size, interpolation=cv2.INTER_NEAREST).astype(bool)
        return cv2.resize(_difference(small, mask, sigma / 2.0), plain.shape[::-1], interpolation=cv2.INTER_LINEAR)
    weight = valid.astype(np.float32)
    blurred = []
    for width in (sigma, sigma * RATIO):
        value = cv2.GaussianBlur(plain * weight, (0, 0), width, borderType=cv2.BORDER_CONSTANT)
        share = cv2.GaussianBlur(weight, (0, 0), width, borderType=cv2.BORDER_CONSTANT)
        blurred.append(value / np.maximum(share, 0.05))
    return blurred[0] - blurred[1]


def _peaks(
    answer: NDArray[np.float32], around: NDArray[np.bool_], sigma: float, scale: float, most: int
) -> list[tuple[float, Candidate]]:
    """The strongest local extremes of one scale, each with its strength."""
    noise = 1.4826 * float(np.median(np.abs(answer[around]))) if around.any() else 0.0
    least = max(LEAST_KELVIN, LEAST_SIGMAS * noise)
    size = 2 * max(1, round(0.7 * sigma / scale)) + 1
    strength = np.abs(answer)
    peak = (strength >= cv2.dilate(strength, np.ones((size, size), np.uint8))) & around & (strength >= least)
    flat = np.flatnonzero(peak)
    flat = flat[np.argsort(-strength.flat[flat], kind="stable")[:most]]
    rows, columns = np.unravel_index(flat, strength.shape)
    return [
        (
            float(strength[r, c]),
            Candidate(_vertex(strength, r, c, 0), _vertex(strength, r, c, 1), 2.8 * sigma, float(answer[r, c])),
        )
        for r, c in zip(rows.tolist(), columns.tolist(), strict=True)
    ]


def _vertex(strength: NDArray[np.float32], row: int, column: int, axis: int) -> float:
    """The peak's place along one axis to a part of a pixel: vertex of the parabola through three samples."""
    at = (row, column)[axis]
    if not 0 < at < strength.shape[axis] - 1:
        return float(at)
    step = (1, 0) if axis == 0 else (0, 1)
    before = float(strength[row - step[0], column - step[1]])
    here = float(strength[row, column])
    after = float(strength[row + step[0], column + step[1]])
    bend = before - 2.0 * here + after
    return at if bend >= -1e-9 else at + max(-0.5, min(0.5, 0.5 * (before - after) / bend))


def _thin(candidates: list[Candidate], spacing: float, most: int) -> list[Candidate]:
    """The strongest of each group of neighbours; a wide blob may not swallow a smaller one beside its centre."""
    kept: list[Candidate] = []
    for candidate in candidates:
        if len(kept) == most:
            break
        if all((candidate.row - o.row) ** 2 + (candidate.column - o.column) ** 2 >= spacing**2 for o in kept):
            kept.append(candidate)
    return kept
