"""Which stretch to drive next: near by first, and off weak spots of the ground while there is another way."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rover.geometry import Pose2
from rover.mission.caution import BOLD, CAUTIOUS, Caution
from rover.mission.freespace import FreeSpace, Mask
from rover.mission.goals import Goal
from rover.mission.targets import Decision, candidates, decide
from rover.planning.replanning import Planner

# Half the side of the square that is looked at first, metres: what a decision costs does not grow with the field then,
# and the rover finishes one corner before it drives to another.
NEAR_M = 5.0


@dataclass(frozen=True, eq=False)
class Choice:
    """decision: None where there is nowhere to go. space: what it was planned on; kept_off: likeness of weak spots."""

    decision: Decision | None
    space: FreeSpace
    kept_off: float


def choose(
    space: FreeSpace,
    caution: Caution,
    pose: Pose2,
    goals: Sequence[Goal],
    unseen: Mask,
    footprint: NDArray[np.float64],
    standoff: float,
    planner: Planner,
) -> Choice:
    """The next stretch; arguments as of `targets.candidates`."""
    near = space.around(np.array([[pose.x, pose.y]]), NEAR_M)
    for kept_off in (CAUTIOUS, BOLD):
        for part in (space,) if near is space else (near, space):
            careful = caution.keep_off(part, kept_off, pose)
            targets = candidates(careful, pose, goals, unseen, footprint, standoff)
            decision = decide(careful, pose, targets, planner)
            if decision is not None:
                return Choice(decision, careful, kept_off)
    return Choice(None, space, BOLD)
