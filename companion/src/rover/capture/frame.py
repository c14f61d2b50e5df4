"""One thermal picture as the camera delivered it, with when it was taken and whether it may be trusted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rover.errors import BadInput

KELVIN_PER_COUNT = 0.01
"""Radiometric cameras here deliver kelvin × 100 (Lepton: TLinear at resolution 0.01 K)."""


@dataclass(frozen=True, eq=False)
class Frame:
    """A 16-bit thermal picture.

    counts: (H, W) uint16, kelvin × 100 unless the source says otherwise.
    time: exposure time in seconds on the companion's clock (not the time of delivery).
    sequence: number of the frame as its source counts; a gap means frames were lost.
    ffc: the shutter was closed or the offsets were being renewed: the picture must not be used.
    Raises BadInput when `counts` is not a 16-bit picture.
    """

    counts: NDArray[np.uint16]
    time: float
    sequence: int
    ffc: bool = False

    def __post_init__(self) -> None:
        if self.counts.ndim != 2 or self.counts.dtype != np.uint16:
            raise BadInput(
                f"frame {self.sequence}: expected a 16-bit picture of one channel, "
                f"got {self.counts.dtype} of shape {self.counts.shape}"
            )

    def kelvin(self) -> NDArray[np.float32]:
        """Temperatures (H, W) in kelvin, for counts of kelvin × 100."""
        return self.counts.astype(np.float32) * np.float32(KELVIN_PER_COUNT)

    @property
    def size(self) -> tuple[int, int]:
        """(width, height) in pixels."""
        return int(self.counts.shape[1]), int(self.counts.shape[0])
