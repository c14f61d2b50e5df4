"""How far the driven path is beside the path that was asked for."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from rover.motion.path.blend import Blend
from rover.motion.path.piece import Piece
from rover.motion.trajectory.driven import Driven

Array = NDArray[np.float64]

# Legs beside those that a piece runs along that are looked at, too.
MORE_LEGS = 2


def deviations(driven: Driven, blend: Blend, starts: Sequence[int]) -> Array:
    """(M − 1,): metres, no less than the distance to the polyline of the way between each two points of the driven one.

    Compared with the legs that its piece runs along, in order, so a path that crosses itself is not mistaken for
    following another part of itself. To a single leg the distance is convex along a chord: at most what it is at the
    ends. `starts`: of the trajectory.
    """
    pieces: list[Piece] = [piece for stretch in blend.stretches for piece in stretch.pieces][: len(starts)]
    if not pieces or len(driven.points) < 2:
        return np.zeros(0)
    count = len(blend.error)
    leg = np.array([piece.leg for piece in pieces])
    first = np.maximum(leg - MORE_LEGS, 0)
    last = np.minimum(np.append(leg[1:], count - 1) + MORE_LEGS + 1, count)
    segment = driven.segments[:-1]
    piece_of = np.clip(np.searchsorted(np.array(starts), segment, side="right") - 1, 0, len(pieces) - 1)
    begin, number = first[piece_of], (last - first)[piece_of]
    rows = np.repeat(np.arange(len(piece_of)), number)
    offsets = np.cumsum(number) - number
    legs = np.arange(len(rows)) - np.repeat(offsets, number) + begin[rows]
    distance = np.maximum(_to_legs(driven.points[rows], legs, blend), _to_legs(driven.points[rows + 1], legs, blend))
    return np.asarray(np.minimum.reduceat(distance + blend.error[legs], offsets) + driven.bulges, dtype=np.float64)


def _to_legs(points: Array, legs: NDArray[np.int64], blend: Blend) -> Array:
    """(K,) distance of each point to the leg of its number."""
    a = blend.points[legs]
    along = blend.points[legs + 1] - a
    off = points - a
    share = np.clip((off * along).sum(axis=1) / (along**2).sum(axis=1), 0.0, 1.0)
    off = off - share[:, None] * along
    return np.asarray(np.hypot(off[:, 0], off[:, 1]), dtype=np.float64)
