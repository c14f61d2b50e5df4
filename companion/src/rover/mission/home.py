"""The way back to the launch, over ground that has been seen: whether it is to be driven, and what came of it."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from rover.geometry import Pose2
from rover.mission.freespace import FreeSpace
from rover.mission.targets import CORNER_COST, PLAN_ITERATIONS, START_ESCAPE
from rover.planning.planner import plan

# Nearer than this to the launch the rover is at home, metres.
AT_HOME_M = 0.15
# Times that a way back is planned without coming nearer: it may be found blocked while it is driven.
MAX_WAYS = 8
# After so many of them in a row the rover looks around first: what one view has blocked another may free.
WAYS_A_LOOK = 3
# What the way keeps off obstacles beyond what must be, where there is room, metres: their edges come and go by a cell.
ROOM_M = (0.04, 0.0)
# Less than this is not nearer, metres.
MIN_NEARER_M = 0.1
# Way back per straight metre, where nobody has looked yet for a way.
DETOUR = 1.6


@dataclass(frozen=True)
class Home:
    """Whether the rover stands at its launch in the end, and why or why not, in one sentence."""

    reached: bool
    reason: str


class WayHome:
    """Of one mission: plans the way back each time the one before was blocked."""

    def __init__(self, launch: Pose2, seed: int) -> None:
        self._launch = launch
        self._seed = seed
        self.ways = 0
        self._fruitless = 0
        self._looked_after = 0
        self._nearest_m = float("inf")

    def reached(self, pose: Pose2) -> bool:
        """True when the rover stands at the launch."""
        return pose.distance(self._launch) <= AT_HOME_M

    def straight_m(self, pose: Pose2) -> float:
        """About how long the way back is, metres."""
        return DETOUR * pose.distance(self._launch)

    @property
    def given_up(self) -> bool:
        """True when no further way is to be tried."""
        return self._fruitless >= MAX_WAYS

    def wants_look(self) -> bool:
        """True, once, when ways have been blocked so often that the rover is to look around before it tries again."""
        due = self._fruitless > 0 and self._fruitless % WAYS_A_LOOK == 0 and self._looked_after != self._fruitless
        if due:
            self._looked_after = self._fruitless
        return due

    def path(self, space: FreeSpace, pose: Pose2) -> NDArray[np.float64] | None:
        """A polyline (N, 2) over free ground to the launch, or to within AT_HOME_M of it; None when there is none."""
        distance = pose.distance(self._launch)
        if distance < self._nearest_m - MIN_NEARER_M:
            self._fruitless, self._looked_after, self._nearest_m = 0, 0, distance
        self.ways += 1
        self._fruitless += 1
        goals = [(self._launch.x, self._launch.y), *_around(self._launch)]
        for room, goal in product(ROOM_M, goals):
            found = plan(
                space.field(),
                (pose.x, pose.y),
                [goal],
                robot_radius=space.radius + room,
                seed=self._seed + self.ways,
                iterations=PLAN_ITERATIONS,
                start_recovery_m=START_ESCAPE,
                corner_cost_m=CORNER_COST,
            )
            if found.order:
                return found.leg(0)
        return None


def _around(launch: Pose2) -> list[tuple[float, float]]:
    """Points near a launch on which itself the rover cannot stand with all its margin."""
    angles = 2.0 * np.pi * np.arange(8) / 8
    reach = 0.8 * AT_HOME_M
    return [(launch.x + reach * float(np.cos(a)), launch.y + reach * float(np.sin(a))) for a in angles]
