"""What the calibration of the network for pictures has come to."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Calibration:
    """factor, offsets (3,): of the logits. threshold: reached by `found` of `mines` mines, and `false` times else."""

    factor: float
    offsets: NDArray[np.floating]
    error: float
    threshold: float
    found: int
    mines: int
    false: int
    pictures: int
