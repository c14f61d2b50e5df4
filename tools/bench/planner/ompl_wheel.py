"""OMPL from its Python wheel as a peer: the planners are C++, the collision check is Python, as its users have it."""

from __future__ import annotations

import importlib
import importlib.util
import math
import time
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

from tools.bench.planner.scenes import Point

# (milliseconds, metres, nodes) of one run
Run = tuple[float, float, float]
PLANNERS = ("RRT", "RRTConnect")


def available() -> bool:
    """True when the wheel can be imported; PyPI has none for every Python."""
    try:
        found = importlib.util.find_spec("ompl")
    except (ImportError, ValueError):
        return False
    return found is not None


def run(
    name: str,
    size: Point,
    circles: Sequence[Sequence[float]],
    stops: Sequence[Point],
    radius: float,
    seeds: int,
) -> list[Run]:
    """First solutions goal by goal, one run a seed. OMPL samples edges every 1 % of the space's extent by itself."""
    # Without stubs, and mostly not installed: looked up by name.
    base, geometric, util = (importlib.import_module(f"ompl.{name}") for name in ("base", "geometric", "util"))

    util.setLogLevel(util.LOG_NONE)
    util.RNG.setSeed(1)

    def free(state: Any) -> bool:
        x, y = state[0], state[1]
        return all((x - cx) ** 2 + (y - cy) ** 2 >= (radius + r) ** 2 for cx, cy, r in circles)

    runs: list[Run] = []
    for _ in range(seeds):
        spent, metres, nodes = 0.0, 0.0, 0.0
        for start, goal in pairwise(stops):
            space = base.RealVectorStateSpace(2)
            bounds = base.RealVectorBounds(2)
            for axis in (0, 1):
                bounds.setLow(axis, radius)
                bounds.setHigh(axis, size[axis] - radius)
            space.setBounds(bounds)
            setup = geometric.SimpleSetup(space)
            setup.setStateValidityChecker(free)
            ends = [space.allocState() for _ in range(2)]
            for state, point in zip(ends, (start, goal), strict=True):
                state[0], state[1] = point
            setup.setStartAndGoalStates(*ends)
            setup.setPlanner(getattr(geometric, name)(setup.getSpaceInformation()))
            setup.setup()
            began = time.thread_time()
            setup.solve(10.0)
            spent += 1e3 * (time.thread_time() - began)
            way = [(state[0], state[1]) for state in setup.getSolutionPath().getStates()]
            metres += sum(math.dist(a, b) for a, b in pairwise(way))
            graph = base.PlannerData(setup.getSpaceInformation())
            setup.getPlannerData(graph)
            nodes += graph.numVertices()
        runs.append((spent, metres, nodes))
    return runs
