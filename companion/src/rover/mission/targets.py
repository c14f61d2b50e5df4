"""Where to go next: one tour by the multi-goal RRT over inspection poses and viewpoints, of which the first is driven.

The planner is the mission's: it goes on from the tree of the decision before, wherever the map has not cut it. The same
maps, poses and seed in the same order give the same decisions.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.geometry import Pose2
from rover.mapping.rectangle import Rectangle
from rover.mission.freespace import FreeSpace, Mask
from rover.mission.goals import Goal
from rover.planning.inspection import inspection_poses
from rover.planning.replanning import Planner
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
# Cells that are searched for a decision at once: 12 × 12 m at 2 cm take some 40 ms.
MAX_CELLS = 400_000
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
    """Every pose worth driving to from here.

    unseen: cells of the whole map still to be shown; footprint: of the camera, in base_link.
    A large field is looked at through a coarser lattice; only where nothing is found on that, cell by cell.
    """
    unseen = unseen[space.where.slices(Rectangle(0, 0, *unseen.shape))]
    step = math.ceil(math.sqrt(space.free.size / MAX_CELLS))
    while True:
        found = _candidates(space, pose, goals, unseen, footprint, standoff, step)
        if found or step == 1:
            return found
        step = 1


def _candidates(
    space: FreeSpace,
    pose: Pose2,
    goals: Sequence[Goal],
    unseen: Mask,
    footprint: NDArray[np.float64],
    standoff: float,
    step: int,
) -> list[Target]:
    """The same among every `step`th cell."""
    every = np.s_[step // 2 :: step, step // 2 :: step]
    free, occluders, unseen = (np.ascontiguousarray(mask[every]) for mask in (space.free, space.occluders, unseen))
    resolution, origin = step * space.resolution, space.origin
    distance = distance_field(free, _way_out(free, pose, resolution, origin), resolution, origin)
    targets = []
    for goal in goals:
        poses = inspection_poses(
            (goal.x, goal.y),
            free,
            resolution,
            distance,
            origin=origin,
            standoffs=(standoff, standoff + 0.1, standoff + 0.2, standoff + 0.3, standoff + 0.4),
            occluders=occluders,
        )
        if poses:
            # Another side each time: what hid the goal from one hides it less from another.
            targets.append(Target(poses[goal.attempts * len(poses) // 3 % len(poses)], goal, 0.0))
    views = viewpoints(~unseen, free, unseen, footprint, pose, resolution, distance, occluders=occluders, origin=origin)
    targets += [Target(view.pose, None, view.gain_m2) for view in _spread(views)]
    return targets


def _way_out(free: Mask, pose: Pose2, resolution: float, origin: tuple[float, float]) -> tuple[float, float]:
    """Where the rover's way begins: where it stands or, when that is not free, where it is within START_ESCAPE.

    Beside an obstacle the nearest free cell may lie in a pocket: it is the largest free ground that leads anywhere.
    """
    row, column = math.floor((pose.y - origin[1]) / resolution), math.floor((pose.x - origin[0]) / resolution)
    inside = 0 <= row < free.shape[0] and 0 <= column < free.shape[1]
    reach = math.ceil(START_ESCAPE / resolution)
    top, left = max(row - reach, 0), max(column - reach, 0)
    near = np.s_[top : max(row + reach + 1, 0), left : max(column + reach + 1, 0)]
    rows, columns = np.nonzero(free[near])
    away = np.hypot(rows + top - row, columns + left - column)
    if not inside or free[row, column] or not (away <= reach).any():
        return pose.x, pose.y
    _, labels, sizes, _ = cv2.connectedComponentsWithStats(free.astype(np.uint8), connectivity=8)
    size = np.where(away <= reach, sizes[labels[near][rows, columns], cv2.CC_STAT_AREA], 0)
    best = int(np.lexsort((away, -size))[0])
    return (
        origin[0] + (int(columns[best]) + left + 0.5) * resolution,
        origin[1] + (int(rows[best]) + top + 0.5) * resolution,
    )


def tour_planner(radius: float, seed: int) -> Planner:
    """The planner of a whole mission, for a disc of `radius` metres."""
    return Planner(
        robot_radius=radius, seed=seed, any_order=True, start_recovery_m=START_ESCAPE, corner_cost_m=CORNER_COST
    )


def decide(space: FreeSpace, pose: Pose2, targets: Sequence[Target], planner: Planner) -> Decision | None:
    """The first stretch of a tour over the targets; None when none of them can be reached."""
    if not targets:
        return None
    places = [(target.pose.x, target.pose.y) for target in targets]
    found = planner.plan(space.field(), (pose.x, pose.y), places, iterations=PLAN_ITERATIONS)
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
