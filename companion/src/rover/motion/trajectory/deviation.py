"""How far the driven path is beside the path that was asked for."""

from __future__ import annotations

import numpy as np
import rover_native
from numpy.typing import NDArray
from rover.motion.path.blend import Blend
from rover.motion.trajectory.driven import Driven

Array = NDArray[np.float64]

# Legs beside those that a piece runs along that are looked at, too.
MORE_LEGS = 2


def deviations(driven: Driven, blend: Blend, starts: NDArray[np.int64]) -> Array:
    """(M − 1,): metres, no less than the distance to the polyline of the way between each two points of the driven one.

    Compared with the legs that its piece runs along, in order, so a path that crosses itself is not mistaken for
    following another part of itself. To a single leg the distance is convex along a chord: at most what it is at the
    ends. `starts`: of the trajectory.
    """
    parts = [part for stretch in blend.stretches for part in stretch.parts]
    leg = np.concatenate([np.atleast_1d(part.leg) for part in parts])[: len(starts)] if parts else np.zeros(0)
    if not len(leg) or len(driven.points) < 2:
        return np.zeros(0)
    count = len(blend.error)
    first = np.maximum(leg - MORE_LEGS, 0)
    last = np.minimum(np.append(leg[1:], count - 1) + MORE_LEGS + 1, count)
    way = (driven.points, driven.segments, driven.bulges)
    legs = np.column_stack([first, last]).astype(np.int64)
    return rover_native.way_beside(way, (blend.points, blend.error), starts[: len(leg)], legs)
