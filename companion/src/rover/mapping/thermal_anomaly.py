"""The binary thermal picture: what stands out of the ground's own warmth (paper section 4.1).

The background is the median, its spread the median absolute deviation: both ignore a few warm or cold things.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

# A cell stands out when it differs by this many standard deviations and by this many kelvin.
LEAST_SIGMAS = 4.0
LEAST_KELVIN = 0.8


def background(kelvin: NDArray[np.float32]) -> tuple[float, float]:
    """Median, and standard deviation estimated from the median absolute deviation, kelvin. Any shape, no nan."""
    middle = float(np.median(kelvin))
    return middle, 1.4826 * float(np.median(np.abs(kelvin - middle)))


def anomalies(kelvin: NDArray[np.float32]) -> NDArray[np.bool_]:
    """True where a temperature stands out, of the same shape as `kelvin`."""
    middle, spread = background(kelvin)
    return np.abs(kelvin - middle) > max(LEAST_SIGMAS * spread, LEAST_KELVIN)
