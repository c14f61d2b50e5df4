"""Parts of the ground's temperature that change while a mission lasts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Layer:
    """Adds `series[t]` x `raster` to the temperature, K, at second t of the mission; the last value stays.

    raster (rows, columns) as the ground's; series (n,), beginning with 0: the ground's own raster is that of second 0.
    """

    raster: NDArray[np.float32]
    series: NDArray[np.float64]
