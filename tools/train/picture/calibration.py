"""What the calibration of the network for pictures has come to."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Calibration:
    """factor, offsets (3,): of the logits. error: expected calibration error of candidates that may be mines.

    threshold: the file's; pd, false_alarms: there, in zones never seen, with intervals for other flights. mines,
    pictures: how many were judged.
    """

    factor: float
    offsets: NDArray[np.floating]
    error: float
    threshold: float
    pd: tuple[float, ...]
    false_alarms: tuple[float, ...]
    mines: int
    pictures: int
