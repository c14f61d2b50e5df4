"""Points through a homography."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]


def apply_homography(homography: Points, points: Points) -> Points:
    """Points (N, 2) through a homography (3, 3)."""
    mapped = points @ homography[:, :2].T + homography[:, 2]
    laid: Points = mapped[:, :2] / mapped[:, 2:]
    return laid
