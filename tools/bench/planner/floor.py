"""Plans without a budget beside grid A* and string pulling, and lengths over budgets, family by family."""

from __future__ import annotations

import time
from itertools import pairwise
from pathlib import Path

import numpy as np
from rover.planning import plan

from tools.bench.planner import peers
from tools.bench.planner.families import Ground, families

# Milliseconds of planning after which a path counts as the optimum, unless a peer's is shorter.
LONG_MS = 300.0
BUDGETS_MS = (0.0, 5.0, 50.0, LONG_MS)
# Each plan is timed so often; the least time counts.
REPEATS = 2


def table(program: Path | None, folder: Path | None, tasks: int, seeds: int) -> str:
    """A row for every family. Times are processor time in milliseconds, of all tasks together.

    The A* knows the inflated cells beforehand; what their making takes is not counted. Ours finds out which edges are
    clear as it goes, once for each ground. Lengths are over the shortest path that anybody found.
    """
    lines = [
        "| family | tasks | ours ms | A* ms | A* + pulling ms | ours / A* + pulling | length / optimum (median / p95) "
        "| A* + pulling: length / optimum | longer with more budget |",
        "|---|--:|--:|--:|--:|--:|--:|--:|--:|",
    ]
    for name, grounds in families(folder, tasks, seeds):
        rows = [row for ground in grounds for row in runs(program, ground)]
        spent, star, pulled, ratio, peer, worse = (np.array(column, dtype=float) for column in zip(*rows, strict=True))
        share = f"{spent.sum() / pulled.sum():.2f}" if program is not None else "–"
        lines.append(
            f"| {name} | {len(rows)} | {spent.sum():.1f} | {star.sum():.1f} | {pulled.sum():.1f} | {share} "
            f"| {spread(ratio)} | {spread(peer)} | {int(worse.sum())} |"
        )
    return "\n".join(lines)


def spread(values: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> str:
    """Median and p95."""
    known = values[np.isfinite(values)]
    return " / ".join(f"{np.percentile(known, p):.3f}" for p in (50, 95)) if known.size else "–"


def runs(program: Path | None, ground: Ground) -> list[tuple[float, ...]]:
    """For each task: our ms, A* ms, A* + pulling ms, both lengths over the optimum, and how often more was worse."""
    unknown = [(float("nan"), float("inf"), 0.0)] * len(ground.tasks)
    star, pulled = unknown, unknown
    if program is not None:
        stops = [point for task in ground.tasks for point in task]
        found = peers.run(program, ground.blocked, ground.resolution, ground.radius, [], stops, order=peers.PAIRS)
        star, pulled = found["a-star"], found["a-star-shortcuts"]
    rows: list[tuple[float, ...]] = []
    for number, (start, goal) in enumerate(ground.tasks):
        took = []
        for _ in range(REPEATS):
            began = time.thread_time()
            floor = plan(ground.field, start, [goal], robot_radius=ground.radius, seed=number)
            took.append(1e3 * (time.thread_time() - began))
        lengths = [floor.length] + [
            plan(ground.field, start, [goal], robot_radius=ground.radius, seed=number, budget_ms=budget).length
            for budget in BUDGETS_MS
        ]
        if not floor.ok or floor.length == 0.0:
            continue
        optimum = min(*lengths, pulled[number][1])
        worse = sum(after > before for before, after in pairwise(lengths))
        rows.append(
            (min(took), star[number][0], pulled[number][0], floor.length / optimum, pulled[number][1] / optimum, worse)
        )
    return rows
