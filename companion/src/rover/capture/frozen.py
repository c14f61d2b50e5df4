"""Cameras without telemetry repeat their last picture while the shutter is closed: so it is noticed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


class FrozenPicture:
    """Tells whether a picture equals the one before, bit for bit: noise never repeats, a held picture does."""

    def __init__(self) -> None:
        self._last: NDArray[np.uint16] | None = None

    def repeats(self, counts: NDArray[np.uint16]) -> bool:
        """Whether `counts` (H, W) is the picture that the last call had."""
        same = self._last is not None and np.array_equal(self._last, counts)
        self._last = counts
        return same
