"""Do two pictures show the same thing where a homography lays one on the other?

Matches can agree with each other and be wrong together: rows of bricks or windows fit after a shift by one of them. The
pictures between the matches don't.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.vision.registration.prepared import Pyramid
from rover.vision.registration.refine import lay

# Pixels of σ over which both are smoothed first: noise agrees with nothing, and parallax moves edges a little.
BLUR_PX = 2.0

# Along each side of what both show.
TILES = 5

# Correlation below which a tile counts as different.
NOTHING_ALIKE = 0.2


def agreement(pyramid_a: Pyramid, pyramid_b: Pyramid, homography: NDArray[np.float64], level: int) -> float:
    """Correlation (-1 to 1) of A laid on B with B, where both are; 0 where they hardly overlap or hold no texture.

    Pyramids: of `local_contrast`, so that a hot corner in both does not pass for agreement. homography: of full size;
    level: how often the pictures that are compared were halved.
    """
    shown = _both(pyramid_a, pyramid_b, homography, level)
    return 0.0 if shown is None else _correlation(shown[0][shown[2]], shown[1][shown[2]])


def disagreeing_share(pyramid_a: Pyramid, pyramid_b: Pyramid, homography: NDArray[np.float64], level: int) -> float:
    """Share of what both pictures show (0 to 1, tile by tile) in which they have nothing in common.

    A homography that is right in one corner alone agrees there so well that the whole still does.
    """
    shown = _both(pyramid_a, pyramid_b, homography, level)
    if shown is None:
        return 1.0
    a, b, both = shown
    rows, columns = np.flatnonzero(both.any(axis=1)), np.flatnonzero(both.any(axis=0))
    tiles = [
        (a[place][both[place]], b[place][both[place]])
        for row in np.array_split(np.arange(rows[0], rows[-1] + 1), TILES)
        for column in np.array_split(np.arange(columns[0], columns[-1] + 1), TILES)
        if len(row) and len(column)
        for place in [np.s_[row[0] : row[-1] + 1, column[0] : column[-1] + 1]]
        if both[place].mean() >= 0.5
    ]
    return float(np.mean([_correlation(*tile) < NOTHING_ALIKE for tile in tiles])) if tiles else 1.0


def _both(
    pyramid_a: Pyramid, pyramid_b: Pyramid, homography: NDArray[np.float64], level: int
) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.bool_]] | None:
    """A laid on B and B, smoothed, and where both are; None where they hardly overlap."""
    smaller = np.diag((0.5**level, 0.5**level, 1.0))
    laid = lay(pyramid_a[level], pyramid_b[level], smaller @ homography @ np.linalg.inv(smaller))
    if laid is None:
        return None
    a, b = (
        np.asarray(cv2.GaussianBlur(p.astype(np.float32), (0, 0), BLUR_PX * 0.5**level), np.float32)
        for p in (laid[0], pyramid_b[level])
    )
    return a, b, laid[1] > 0


def _correlation(a: NDArray[np.float32], b: NDArray[np.float32]) -> float:
    a, b = a - a.mean(), b - b.mean()
    power = float(np.sqrt((a @ a) * (b @ b)))
    return float(a @ b) / power if power > 0.0 else 0.0
