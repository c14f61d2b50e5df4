"""Paths as a mission plans them, on its own map of the clearance: rounding is quicker than turning on the spot.

python tests/motion/test_follow_planned.py 100      # the comparison of docs/results/motion.md, over so many fields
"""

from __future__ import annotations

import math
import sys

import numpy as np
import pytest
from rover.geometry import Pose2
from rover.mission.config import Area, Launch
from rover.mission.freespace import free_space
from rover.motion.path.clearance import ClearanceMap
from rover.planning.planner import plan
from rover.vehicle import Vehicle

from companion.tests.motion.motion_simulation import drive

CELL = 0.02


def both_ways(seed: int):
    """(corners, seconds and least clearance turning on the spot, the same rounding), or None where no path leads."""
    rng = np.random.default_rng([seed, 77])
    columns = (rng.uniform(0.3, 2.7, 9), rng.uniform(0.3, 3.7, 9), rng.uniform(0.08, 0.2, 9))
    obstacles = tuple((float(x), float(y), float(r)) for x, y, r in zip(*columns, strict=True))
    seen = np.ones((200, 150), bool)
    launch = Launch(Pose2(0.5, 0.5, 0.0), 0.25)
    space = free_space(~seen, seen, CELL, (), Area(3.0, 4.0, obstacles), launch, Vehicle())
    free = (np.argwhere(space.free)[:, ::-1] + 0.5) * CELL
    if len(free) < 100:
        return None
    start, goal = ((float(free[number][0]), float(free[number][1])) for number in rng.integers(len(free), size=2))
    heading, final = (float(value) for value in rng.uniform(-3.0, 3.0, 2))
    found = plan(space.field(), start, [goal], robot_radius=space.radius, seed=seed)
    if not found.ok or math.dist(start, goal) < 1.0:
        return None
    path = [(float(x), float(y)) for x, y in found.path]
    result: list[float] = [len(path) - 2]
    for clearance in (None, ClearanceMap.of(space.field(), space.radius)):
        follower, _, log = drive(
            path,
            final,
            start=Pose2(*path[0], heading),
            wheels=(0.97, 0.95),
            noise=(0.004, 0.006),
            seed=seed,
            clearance=clearance,
        )
        assert log.finished
        assert not follower.lost
        gap = space.field().clearance(np.array([(pose.x, pose.y) for pose in log.poses])).min() - Vehicle().radius
        result += [log.times[-1], float(gap)]
    return result


@pytest.mark.slow
def test_planned_paths_with_corners_take_less_time_and_the_rover_touches_nothing():
    pairs = [pair for pair in map(both_ways, range(2, 12)) if pair is not None and pair[0]]
    rows = np.array(pairs)
    assert len(rows) > 3
    assert rows[:, 3].sum() < 0.9 * rows[:, 1].sum()
    assert (rows[:, 3] < 1.1 * rows[:, 1]).all()
    assert rows[:, 4].min() > 0.0


if __name__ == "__main__":
    every = [pair for pair in map(both_ways, range(int(sys.argv[1]))) if pair is not None]
    table = np.array([pair for pair in every if pair[0]])
    print(f"{len(every)} paths, {len(table)} with corners")
    for name, column in (("turning on the spot", 1), ("rounding", 3)):
        seconds, gap = table[:, column].sum(), 1e3 * table[:, column + 1].min()
        print(f"{name}: {seconds:.0f} s on those with corners, least clearance {gap:.0f} mm")
    quicker, slower = (table[:, 3] < table[:, 1] - 0.1).sum(), (table[:, 3] > table[:, 1] + 0.1).sum()
    print(f"rounding is quicker on {quicker}, slower on {slower}")
