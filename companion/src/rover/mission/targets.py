"""Where to go next: one tour by the multi-goal RRT over inspection poses and viewpoints, of which the first is driven.

Pure: the same map, pose and seed give the same decision.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from rover.geometry import Pose2
from rover.mission.freespace import FreeSpace, Mask
from rover.mission.goals import Goal
from rover.planning.inspection import inspection_poses
from rover.planning.planner import plan
from rover.planning.viewpoints import Viewpoint, distance_field, viewpoints

# A tour over more would look further ahead than the map stays true.
MAX_VIEWPOINTS = 4
# Viewpoints nearer to each other than this show much the same ground.
VIEWPOINT_SPACING = 0.5
# Less unseen ground than this, in m², is not worth a drive.
MIN_GAIN = 0.03
# Tree extensions and shortcuts of one plan: a fixed number, not a time, so that a mission can be repeated.
PLAN_ITERATIONS = 3000
# Localization may put the rover this far into its own margin; it may drive out again.
START_ESCAPE = 0.15
# A corner is turned on the spot, which takes as long as this many metres of driving.
CORNER_COST = 0.25


@dataclass(frozen=True, eq=False)
class Target:
    """A pose to drive to. goal: the goal inspected there, None for a viewpoint."""

    pose: Pose2
    goal: Goal | None
    gain_m2: float

    def moved(self, shift: Pose2) -> Target:
        """The same once its ground has moved in map by `shift`."""
        return replace(self, pose=shift.compose(self.pose))


@dataclass(frozen=True, eq=False)
class Decision:
    """The next stretch. path: polyline (N, 2) in map; tour: all targets in the order planned."""

    target: Target
    path: NDArray[np.float64]
    tour: tuple[Target, ...]
    iterations: int
    nodes: int
    length: float


def candidates(
    space: FreeSpace, pose: Pose2, goals: Sequence[Goal], unseen: Mask, footprint: NDArray[np.float64], standoff: float
) -> list[Target]:
    """Every pose worth driving to from here. unseen: cells still to be shown; footprint: of the camera, base_link."""
    distance = distance_field(space.free, (pose.x, pose.y), space.resolution, snap=START_ESCAPE)
    targets = []
    for goal in goals:
        poses = inspection_poses(
            (goal.x, goal.y),
            space.free,
            space.resolution,
            distance,
            standoffs=(standoff, standoff + 0.1, standoff + 0.2, standoff + 0.3, standoff + 0.4),
            occluders=space.occluders,
        )
        if poses:
            # Another side each time: what hid the goal from one hides it less from another.
            targets.append(Target(poses[goal.attempts * len(poses) // 3 % len(poses)], goal, 0.0))
    views = viewpoints(
        ~unseen, space.free, unseen, footprint, pose, space.resolution, distance, occluders=space.occluders
    )
    targets += [Target(view.pose, None, view.gain_m2) for view in _spread(views)]
    return targets


def decide(space: FreeSpace, pose: Pose2, targets: Sequence[Target], seed: int) -> Decision | None:
    """The first stretch of a tour over the targets; None when none of them can be reached."""
    if not targets:
        return None
    found = plan(
        space.field(),
        (pose.x, pose.y),
        [(target.pose.x, target.pose.y) for target in targets],
        robot_radius=space.radius,
        seed=seed,
        iterations=PLAN_ITERATIONS,
        any_order=True,
        start_recovery_m=START_ESCAPE,
        corner_cost_m=CORNER_COST,
    )
    if not found.order:
        return None
    tour = tuple(targets[index] for index in found.order)
    return Decision(tour[0], found.leg(0), tour, found.iterations, found.nodes, found.length)


def _spread(views: Sequence[Viewpoint]) -> list[Viewpoint]:
    """The best views that lie apart, best first."""
    chosen: list[Viewpoint] = []
    for view in views:
        if view.gain_m2 < MIN_GAIN or len(chosen) == MAX_VIEWPOINTS:
            continue
        if all(view.pose.distance(other.pose) >= VIEWPOINT_SPACING for other in chosen):
            chosen.append(view)
    return chosen
