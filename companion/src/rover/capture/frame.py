"""One thermal picture as a camera delivered it: when it was taken, what its counts mean, whether it can be trusted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rover.errors import BadInput

# Radiometric cameras here deliver kelvin × 100 (Lepton: TLinear at resolution 0.01 K).
KELVIN_PER_COUNT = 0.01


@dataclass(frozen=True, eq=False)
class Frame:
    """A 16-bit thermal picture.

    counts: (H, W) uint16, kelvin × 100 unless the source says otherwise.
    time: exposure time in seconds on the companion's clock (not the time of delivery).
    sequence: number of the frame as its source counts; a gap means frames were lost.
    ffc: the shutter was closed or the offsets were being renewed: the picture must not be used.
    since_ffc: seconds between the last renewal of the offsets and the exposure; None where nobody knows.
    kelvin_per_count: what one count means; None for a sensor's raw counts, which are no temperatures.
    camera: what delivered it, as far as it says; may be empty.
    shown: (H, W), False where a picture that was put right holds nothing; None: all of it is a picture.
    doubt: why the counts cannot be temperatures of ground, where that is known.
    Raises BadInput when `counts` is not a 16-bit picture.
    """

    counts: NDArray[np.uint16]
    time: float
    sequence: int
    ffc: bool = False
    since_ffc: float | None = None
    kelvin_per_count: float | None = KELVIN_PER_COUNT
    camera: str = ""
    doubt: str | None = None
    shown: NDArray[np.bool_] | None = None

    def __post_init__(self) -> None:
        if self.counts.ndim != 2 or self.counts.dtype != np.uint16:
            raise BadInput(
                f"frame {self.sequence}: expected a 16-bit picture of one channel, "
                f"got {self.counts.dtype} of shape {self.counts.shape}"
            )

    def kelvin(self) -> NDArray[np.float32]:
        """Temperatures (H, W) in kelvin. Raises BadInput for raw counts."""
        if self.kelvin_per_count is None:
            raise BadInput(f"frame {self.sequence}: raw counts of {self.camera or 'its sensor'} are no temperatures")
        kelvin: NDArray[np.float32] = self.counts.astype(np.float32) * np.float32(self.kelvin_per_count)
        return kelvin

    @property
    def size(self) -> tuple[int, int]:
        """(width, height) in pixels."""
        return int(self.counts.shape[1]), int(self.counts.shape[0])
