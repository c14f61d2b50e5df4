"""Do two pictures show the same thing where a homography lays one on the other?

Matches can agree with each other and be wrong together: rows of bricks or windows fit after a shift by one of them. The
pictures between the matches don't.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.vision.refine import lay

BLUR = 2.0
"""Pixels of σ over which both are smoothed first: noise agrees with nothing, and parallax moves edges a little."""


def agreement(
    picture_a: NDArray[np.uint8], picture_b: NDArray[np.uint8], homography: NDArray[np.float64]
) -> float:
    """Correlation (-1 to 1) of A laid on B with B, where both are; 0 where they hardly overlap or hold no texture.

    Pictures: (H, W) uint8 of `local_contrast`, so that a hot corner in both does not pass for agreement.
    """
    laid = lay(picture_a, picture_b, homography)
    if laid is None:
        return 0.0
    both = laid[1] > 0
    a, b = (cv2.GaussianBlur(p.astype(np.float32), (0, 0), BLUR)[both] for p in (laid[0], picture_b))
    a, b = a - a.mean(), b - b.mean()
    power = float(np.sqrt((a @ a) * (b @ b)))
    return float(a @ b) / power if power > 0.0 else 0.0
