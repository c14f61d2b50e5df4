"""Where segments exceed a limit, and how these places are driven more gently."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, dataclass, replace

import numpy as np
import rover_native
from numpy.typing import NDArray
from rover.motion.path.limits import DrivingLimits
from rover.motion.path.piece import Chain, Piece
from rover.motion.trajectory.extrema import Extrema

Array = NDArray[np.float64]

# What exceeds a limit is slowed by a little more than it lacks, and by so much more each time; so often at most.
RESERVE, MORE, MAX_SLOWDOWNS = 0.005, 0.5, 20
# Names of what counts as a speed; the others are accelerations and jerks.
_SPEEDS = np.array([True, False, False, True, False, False, True])


@dataclass(frozen=True, eq=False)
class Excess:
    """(N,) of each segment: the largest share of a speed's limit, and of one of acceleration and jerk."""

    speed: Array
    change: Array

    @classmethod
    def of(cls, fields: NDArray[np.int64], limits: DrivingLimits) -> Excess:
        """Of segments (N, 5) from rest."""
        shares = rover_native.segment_magnitudes(fields) / np.array(astuple(Extrema.allowed(limits)))
        return cls(shares[:, _SPEEDS].max(axis=1), shares[:, ~_SPEEDS].max(axis=1))

    @property
    def any(self) -> bool:
        """True when a limit is exceeded."""
        return bool((self.speed > 1.0).any() or (self.change > 1.0).any())


def gentler(parts: Sequence[Piece | Chain], excess: Excess, starts: Sequence[int], attempt: int) -> list[Piece | Chain]:
    """The parts, slower where a limit is exceeded. `starts`: number of the first segment of each; `attempt`: how often
    they were made gentler before."""
    found: list[Piece | Chain] = []
    for part, low, high in zip(parts, starts, [*starts[1:], len(excess.speed)], strict=True):
        speed, change = excess.speed[low:high], excess.change[low:high]
        if max(speed.max(initial=0.0), change.max(initial=0.0)) <= 1.0:
            found.append(part)
        elif isinstance(part, Piece):
            found.append(replace(part, speed=part.speed * _less(max(speed.max(), change.max()))))
        else:
            factor, gentle = (_spread(each.reshape(-1, 3).max(axis=1), attempt) for each in (speed, change))
            found.append(replace(part, most=part.most * factor, share=part.share * gentle))
    return found


def _less(most: float) -> float:
    return 1.0 / most - RESERVE


def _spread(most: Array, attempt: int) -> Array:
    """What each curve of a bend is slowed down by, from the shares of limits on it, and its neighbours half as much:
    the more and the farther the more often that was not enough."""
    lack = np.where(most > 1.0, 1.0 - (1.0 / np.maximum(most, 1.0) - RESERVE), 0.0) * (1.0 + MORE * attempt)
    beside = lack
    for _ in range(1 + attempt // 2):
        beside = np.maximum(beside, np.maximum(np.append(beside[1:], 0.0), np.append(0.0, beside[:-1])))
    return np.asarray(1.0 - np.minimum(np.maximum(lack, 0.5 * beside), 0.5), dtype=np.float64)
