"""What one tree towards all goals (figure 3) saves over a tree a goal (section 3.5), by where the goals lie."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from rover.planning import CircleField, Field, plan
from rover.planning.plot import GOAL_BIAS, STEP_SHARE, TREE_EXTENSIONS

from tools.bench.planner.scenes import PAPER_GOALS, PAPER_START, RADIUS, Point, paper_field

SIDE = 10.0
CIRCLES = 30
# Start and goals on 10 × 10 m.
LAYOUTS: dict[str, tuple[Point, Sequence[Point]]] = {
    "two goals side by side": ((0.5, 0.5), [(9.5, 9.0), (9.0, 9.5)]),
    "four goals in a row": ((0.5, 5.0), [(3.0, 5.0), (5.0, 5.0), (7.0, 5.0), (9.5, 5.0)]),
    "two goals, the start between": ((5.0, 5.0), [(0.5, 5.0), (9.5, 5.0)]),
    "four goals around the start": ((5.0, 5.0), [(0.5, 5.0), (9.5, 5.0), (5.0, 0.5), (5.0, 9.5)]),
    "six goals to and fro": ((0.5, 0.5), [(9.5, 2.0), (0.5, 3.5), (9.5, 5.0), (0.5, 6.5), (9.5, 8.0), (0.5, 9.5)]),
}


def table(seeds: int, fields: int = 6) -> str:
    """Medians over fields of medians over seeds: extensions and nodes of the trees alone, until all goals are met."""
    lines = [
        "| goals | extensions: a tree a goal | one tree | nodes: a tree a goal | one tree |",
        "|---|--:|--:|--:|--:|",
    ]
    tasks: dict[str, list[tuple[Field, Point, Sequence[Point]]]] = {
        "the paper's two": [(paper_field(), PAPER_START, PAPER_GOALS)]
    }
    for name, (start, goals) in LAYOUTS.items():
        rng = np.random.default_rng(0)
        tasks[name] = [(cluttered(rng, [start, *goals]), start, goals) for _ in range(fields)]
    for name, grounds in tasks.items():
        counts = np.array([[counted(*ground, seed) for seed in range(seeds)] for ground in grounds], dtype=float)
        staged, nodes, one, one_nodes = np.median(np.median(counts, axis=1), axis=0)
        lines.append(f"| {name} | {staged:.0f} | {one:.0f} | {nodes:.0f} | {one_nodes:.0f} |")
    return "\n".join(lines)


def counted(field: Field, start: Point, goals: Sequence[Point], seed: int) -> tuple[int, int, int, int]:
    """Extensions and nodes of goal-seeking's trees and of the one tree."""
    staged = plan(field, start, goals, algorithm="goal-seeking", robot_radius=RADIUS, seed=seed)
    extensions = sum(stage.iterations for stage in staged.stages if stage.name == "tree")
    left, bottom, right, top = field.bounds
    step = STEP_SHARE * math.hypot(right - left, top - bottom)
    nodes, _, _, tried = field.native.multi_goal_tree(
        start, np.array(goals), RADIUS, seed, TREE_EXTENSIONS, step, GOAL_BIAS
    )
    return extensions, staged.nodes, tried, len(nodes)


def cluttered(rng: np.random.Generator, clear: Sequence[Point]) -> CircleField:
    """Circles of 0.2 to 0.5 m that leave room at the points of `clear`."""
    circles: list[tuple[float, float, float]] = []
    while len(circles) < CIRCLES:
        (x, y), radius = rng.uniform(0.8, SIDE - 0.8, 2).tolist(), float(rng.uniform(0.2, 0.5))
        if all(math.dist((x, y), point) > radius + 0.5 for point in clear):
            circles.append((x, y, radius))
    return CircleField(SIDE, SIDE, circles)
