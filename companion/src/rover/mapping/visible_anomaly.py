"""The binary visible picture: what differs in lightness from the ground around it (paper section 4.1, figure 5a).

Lightness changes slowly with sun and cloud, so it is compared with a wide mean and not with one value for the whole
picture. A shadow's edge still stands out, which is what makes the thermal grid the better one.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

# The ground around is a mean over this share of the longer side.
AROUND = 0.25
MIN_SIGMAS = 3.5
MIN_LEVELS = 12.0


def visible_anomalies(lightness: NDArray[np.floating] | NDArray[np.uint8]) -> NDArray[np.bool_]:
    """Where a picture (h, w) of grey levels 0 to 255 stands out of the ground around."""
    levels = np.asarray(lightness, np.float32)
    side = 2 * round(0.5 * AROUND * max(levels.shape)) + 1
    away = levels - cv2.blur(levels, (side, side), borderType=cv2.BORDER_REFLECT)
    middle = float(np.median(away))
    spread = 1.4826 * float(np.median(np.abs(away - middle)))
    standing_out: NDArray[np.bool_] = np.abs(away - middle) > max(MIN_SIGMAS * spread, MIN_LEVELS)
    return standing_out
