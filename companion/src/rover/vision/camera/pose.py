"""Where a camera stood when it took a frame: what both ways of tracking give."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class CameraPose:
    """frame: its number. position (3,) and rotation (3, 3): camera_optical to the axes of the tracking's map."""

    frame: int
    position: NDArray[np.float64]
    rotation: NDArray[np.float64]
