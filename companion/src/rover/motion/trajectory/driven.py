"""What quantised segments really do: where the rover goes, integrated from the integers that are sent, all at once.

Nothing of the plan is taken on trust.
"""

from __future__ import annotations

import numpy as np
import rover_native
from numpy.typing import NDArray
from rover.motion.path.clearance import ClearanceMap
from rover.motion.trajectory.extrema import Extrema
from rover.motion.trajectory.plan import Trajectory

Array = NDArray[np.float64]

# Metres: a path may touch what it goes around, and whole microseconds put the rover beside it by less than this.
ROUNDING_M = 2e-5


class Driven:
    """The motion of a trajectory. `points` (M, 2): where it passes, with chords that the way leaves by
    at most `bulges` (M - 1).

    `segments` (M,): the segment that each point is in. `poses` (N + 1, 3): x, y, heading at the beginning of each of
    the N segments and at the end of the last.
    """

    def __init__(self, trajectory: Trajectory) -> None:
        pose = (trajectory.x, trajectory.y, trajectory.heading)
        self.poses, self.points, self.segments, self.bulges, most = rover_native.segments_way(trajectory.fields, pose)
        self.extrema = Extrema(*most)

    def touching(self, clearance: ClearanceMap) -> Array:
        """(K, 2): where the footprint touches something, but for ROUNDING_M; none when it is clear all the way."""
        a, b = self.points[:-1], self.points[1:]
        moves = np.hypot(*(b - a).T) > 1e-9
        clear = clearance.swept(a[moves], b[moves], self.bulges[moves] - ROUNDING_M)
        return np.asarray(a[moves][~clear], dtype=np.float64)
