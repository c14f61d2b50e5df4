"""Where segments exceed a limit, and how these places are driven more gently."""

from __future__ import annotations

from dataclasses import astuple, replace

import numpy as np
from numpy.typing import NDArray
from rover.motion.path.limits import DrivingLimits
from rover.motion.path.piece import Chain, Piece
from rover.motion.trajectory.extrema import Extrema

Array = NDArray[np.float64]

# What exceeds a limit is slowed by a little more than it lacks, and by so much more each time; so often at most.
RESERVE, MORE, MAX_SLOWDOWNS = 0.005, 0.5, 20


def allowed(limits: DrivingLimits) -> tuple[float, ...]:
    """In the order of Extrema."""
    return astuple(Extrema.allowed(limits))


def gentler(part: Piece | Chain, shares: Array, attempt: int) -> Piece | Chain:
    """A part, slower where `shares` (N, 2) of its segments, of the limits of speeds and of those of accelerations and
    jerks, are more than one. `attempt`: how often it was made gentler before."""
    if isinstance(part, Piece):
        return replace(part, speed=part.speed * _less(float(shares.max())))
    factor, gentle = (_spread(each, attempt) for each in shares.reshape(-1, 3, 2).max(axis=1).T)
    return replace(part, most=part.most * factor, share=part.share * gentle)


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
