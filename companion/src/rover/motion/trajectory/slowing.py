"""Where segments along bends exceed a limit, and how these places are driven more gently."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import astuple, replace

import numpy as np
from rover.motion.path.limits import DrivingLimits
from rover.motion.path.piece import Piece, Stretch
from rover.motion.trajectory.extrema import Extrema, magnitudes
from rover.vehicle import Limits

# A piece that exceeds a limit is driven at this share of its speed, so often at most; the acceleration of so many
# pieces on both sides is this share of what it was.
SLOWER, MAX_SLOWDOWNS = 0.96, 20
GENTLER, GENTLER_REACH = 0.85, 2


def exceeding(numbers: Sequence[tuple[int, int, int, bool, bool]], limits: DrivingLimits) -> list[int]:
    """Numbers of the segments, from rest to rest, in which a limit is exceeded."""
    rows = np.array(numbers, dtype=np.float64)
    t, jerk, turn_jerk = 1e-6 * rows[:, 0], 1e-6 * rows[:, 1], 1e-6 * rows[:, 2]
    over = np.zeros(len(rows), dtype=bool)
    for values, bound in zip(
        magnitudes(t, jerk, turn_jerk, rows[:, 4] > 0.0), astuple(Extrema.allowed(limits)), strict=True
    ):
        over |= values > bound
    return [int(number) for number in np.flatnonzero(over)]


def slower(stretch: Stretch, numbers: Collection[int]) -> Stretch:
    """The same with the numbered pieces driven slower, and the speed changed more gently in their neighbourhood."""
    near = {number + step for number in numbers for step in range(-GENTLER_REACH, GENTLER_REACH + 1)}
    pieces = [
        _slowed(piece, SLOWER if number in numbers else 1.0) if number in near else piece
        for number, piece in enumerate(stretch.pieces)
    ]
    return Stretch(tuple(pieces))


def _slowed(piece: Piece, share: float) -> Piece:
    change = piece.change
    if change is not None:
        change = Limits(share * change.speed, GENTLER * change.acceleration, GENTLER**2 * change.jerk)
    return replace(piece, speed=share * piece.speed, change=change)
