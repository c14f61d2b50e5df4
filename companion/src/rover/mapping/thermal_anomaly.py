"""The binary thermal picture: what stands out of the ground's own warmth (paper section 4.1).

The background is the median, its spread the median absolute deviation: both ignore a few warm or cold things.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

# A cell stands out when it differs by this many standard deviations and by this many kelvin.
MIN_SIGMAS = 4.0
MIN_KELVIN = 0.8
# The same where the classifier has already said that an obstacle stands.
WEAK_SIGMAS = 2.0
WEAK_KELVIN = 0.35


def background(kelvin: NDArray[np.float32]) -> tuple[float, float]:
    """Median, and standard deviation estimated from the median absolute deviation, kelvin. Any shape, no nan."""
    middle = float(np.median(kelvin))
    return middle, 1.4826 * float(np.median(np.abs(kelvin - middle)))


def anomalies(kelvin: NDArray[np.float32]) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Where a temperature stands out strongly, and where it stands out at all; each of the shape of `kelvin`."""
    middle, spread = background(kelvin)
    away = np.abs(kelvin - middle)
    strong = away > max(MIN_SIGMAS * spread, MIN_KELVIN)
    return strong, away > max(WEAK_SIGMAS * spread, WEAK_KELVIN)
