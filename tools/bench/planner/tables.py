"""The measurements, each a Markdown table. Milliseconds, of processor time unless a table says otherwise; metres."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rover.planning import ALGORITHMS, GridField, Planner, PlanResult, plan
from rover.planning.replanning import Repair

from tools.bench.planner import ompl_wheel, peers
from tools.bench.planner.figure import boxes
from tools.bench.planner.scenes import (
    PAPER_GOALS,
    PAPER_OBSTACLES,
    PAPER_OPTIMUM,
    PAPER_START,
    RADIUS,
    RESOLUTION,
    Scene,
    change,
    paper_field,
    random_scene,
    rasterise,
)

MAPS = ("32room_002", "den312d", "maze512-8-0", "random512-15-3")


def spread(values: Sequence[float], digits: int = 3) -> str:
    """Median and p95."""
    return " / ".join(f"{np.percentile(values, p):.{digits}f}" for p in (50, 95)) if len(values) else "–"


def timed(run: Callable[[], PlanResult]) -> tuple[float, PlanResult]:
    """Milliseconds of processor time of the planning thread, and the plan."""
    began = time.thread_time()
    found = run()
    return 1e3 * (time.thread_time() - began), found


def paper_table(program: Path | None, seeds: int, figure: Path | None = None) -> str:
    """Table 4 of the paper in form: time, iterations, nodes and length on its field, ours and the peers'."""
    lines = [
        "| planner | time ms (median / p95) | iterations | nodes | length m | p95 × optimum |",
        "|---|--:|--:|--:|--:|--:|",
    ]

    drawn: dict[str, tuple[list[float], list[float]]] = {}

    def row(name: str, times: list[float], iterations: list[float], nodes: list[float], lengths: list[float]) -> None:
        drawn[name] = (times, lengths)
        worst = np.percentile(lengths, 95) / PAPER_OPTIMUM
        count = f"{np.median(iterations):.0f}" if iterations else "–"
        lines.append(
            f"| {name} | {spread(times)} | {count} | {np.median(nodes):.0f} | {spread(lengths)} | {worst:.4f} |"
        )

    for budget in (None, 5.0):
        for algorithm in ALGORITHMS:
            field = paper_field()
            planned = [
                timed(partial(plan, field, PAPER_START, PAPER_GOALS, algorithm=algorithm, seed=seed, budget_ms=budget))
                for seed in range(seeds)
            ]
            results = [result for _, result in planned]
            times = [(r.first_solution_ms or 0.0) if budget is None else ms for ms, r in planned]
            name = f"rover {algorithm}, " + ("first solution" if budget is None else f"{budget:g} ms")
            row(name, times, [r.iterations for r in results], [r.nodes for r in results], [r.length for r in results])
    stops = (PAPER_START, *PAPER_GOALS)
    if program is not None:
        fine = 0.02
        # The cells that the paper's circles touch, on the rectangle alone.
        blocked = rasterise(4.0, np.array(PAPER_OBSTACLES), fine)[:, : round(3.0 / fine)]
        found = peers.run(program, blocked, fine, RADIUS, PAPER_OBSTACLES, stops, ompl_seeds=seeds)
        for method in (method for method in found if method != "inflation"):
            runs = found[method]
            row(f"C++ {method}", [r[0] for r in runs], [], [r[2] for r in runs], [r[1] for r in runs])
    for name in ompl_wheel.PLANNERS if ompl_wheel.available() else ():
        runs = ompl_wheel.run(name, (3.0, 4.0), PAPER_OBSTACLES, stops, RADIUS, seeds)
        row(f"OMPL's wheel, {name}, check in Python", [r[0] for r in runs], [], [r[2] for r in runs],
            [r[1] for r in runs])  # fmt: skip
    for star in (False, True):
        runs = [peers.python_rrt((3.0, 4.0), PAPER_OBSTACLES, stops, RADIUS, s, star=star) for s in range(seeds)]
        name = f"plain Python RRT{'*' if star else ''} (PythonRobotics' kind, written anew)"
        row(name, [r[0] for r in runs], [], [r[2] for r in runs], [r[1] for r in runs])
    if figure is not None:
        boxes(drawn, figure)
    return "\n".join(lines)


def map_table(folder: Path, budget_ms: float, every: int) -> str:
    """MovingAI scenarios: length over the optimal octile length."""
    lines = [
        "| map | solved | first solution ms (median / p95) | ms used (median / p95) | length / octile optimum "
        "| longest |",
        "|---|--:|--:|--:|--:|--:|",
    ]
    for name in MAPS:
        field = GridField.load_movingai(folder / f"{name}.map")
        rows = [line.split("\t") for line in (folder / f"{name}.map.scen").read_text().splitlines()[1:] if line]
        ratios, firsts, used, count = [], [], [], 0
        for number, cells in enumerate(rows[::every]):
            x, y, goal_x, goal_y = (int(cell) + 0.5 for cell in cells[4:8])
            found = plan(field, (x, y), [(goal_x, goal_y)], robot_radius=1 / 3, seed=number, budget_ms=budget_ms)
            count += 1
            if found.ok and found.first_solution_ms is not None:
                ratios.append(found.length / float(cells[8]) if float(cells[8]) > 0.0 else 1.0)
                firsts.append(found.first_solution_ms)
                used.append(found.time_ms)
        lines.append(
            f"| {name} | {len(ratios)}/{count} | {spread(firsts, 1)} | {spread(used, 1)} | {spread(ratios)} "
            f"| {max(ratios):.3f} |"
        )
    return "\n".join(lines)


def map_server_table(folder: Path, budget_ms: float, seeds: int, radius: float = 0.2) -> str:
    """Random pairs of free points on map_server maps; a pair in two rooms without a door counts as not solved."""
    lines = [
        "| map | solved | first solution ms (median / p95) | ms used (median / p95) | longest way m |",
        "|---|--:|--:|--:|--:|",
    ]
    for path in sorted(folder.glob("*.yaml")):
        field = GridField.load_map_server(path)
        rng = np.random.default_rng(0)
        left, bottom, right, top = field.bounds
        points = [(float(x), float(y)) for x, y in rng.uniform((left, bottom), (right, top), (200 * seeds, 2))]
        free = [point for point in points if field.segment_clear(point, point, radius)][: 2 * seeds]
        runs = [
            plan(field, start, [goal], robot_radius=radius, seed=seed, budget_ms=budget_ms)
            for seed, (start, goal) in enumerate(zip(free[::2], free[1::2], strict=False))
        ]
        solved = [found for found in runs if found.ok]
        lines.append(
            f"| {path.stem} | {len(solved)}/{len(runs)} | {spread([r.first_solution_ms or 0.0 for r in solved], 2)} "
            f"| {spread([r.time_ms for r in solved], 1)} | {max((r.length for r in solved), default=0.0):.1f} |"
        )
    return "\n".join(lines)


def field_table(program: Path | None, seeds: int, sizes: Sequence[float], goals: Sequence[int]) -> str:
    """Tours in any order over ground that is 40 % blocked, beside A* legs (no shortcuts) with exact ordering.

    The budget of each tour, by the clock, is 0.8 of the processor time that the A* took on the same ground just
    before. The A* gets its inflated cells for nothing; what they take is in a column of its own.
    """
    lines = [
        "| field | goals | map | first tour ms (median / p95) | A* legs, exact order ms | inflation ms | ours ms "
        "| tour / A* tour | tour / A* with shortcuts |",
        "|---|--:|---|--:|--:|--:|--:|--:|--:|",
    ]
    for size in sizes:
        for count in goals:
            figures: dict[str, list[tuple[float, ...]]] = {"circles": [], "cells": []}
            for seed in range(seeds):
                scene = random_scene(size, count, seed)
                stops = (scene.start, *scene.goals)
                ms, inflation, plain, short = 1000.0, float("nan"), float("nan"), float("nan")
                if program is not None:
                    found = peers.run(program, scene.blocked, RESOLUTION, RADIUS, [], stops, order=peers.ANY)
                    ms, plain, _ = found["a-star"][0]
                    short = found["a-star-shortcuts"][0][1]
                    inflation = found["inflation"][0][0]
                for kind, field in (("circles", scene.circle_field()), ("cells", scene.grid_field())):
                    tour = partial(
                        plan, field, scene.start, scene.goals, robot_radius=RADIUS, seed=seed, any_order=True
                    )
                    spent, ours = timed(partial(tour, budget_ms=0.8 * ms))
                    length = ours.length if ours.ok else float("inf")
                    first = ours.first_solution_ms if ours.ok and ours.first_solution_ms else float("inf")
                    figures[kind].append((first, ms, inflation, spent, length / plain, length / short))
            for kind, runs in figures.items():
                columns = [list(column) for column in zip(*runs, strict=True)]
                firsts, plain_ms, inflated, spents, ratio, ratio_short = columns
                lines.append(
                    f"| {size:g} m | {count} | {kind} | {spread(firsts, 1)} | {spread(plain_ms, 0)} "
                    f"| {spread(inflated, 0)} | {spread(spents, 0)} | {spread(ratio)} | {spread(ratio_short)} |"
                )
    return "\n".join(lines)


def replan_table(seeds: int, sizes: Sequence[float], first: int = 0, share: float = 0.05, repeats: int = 3) -> str:
    """Planning again after `share` of the cells changed, beside planning afresh on the changed map.

    Both times are processor time of the planning thread from the array of cells to the path, so each contains what it
    needs of the clearance field; the least of `repeats` runs counts. Every timed run comes right after an untimed plan
    on the old map, so that both find the same caches. What `Planner.prepare` takes, on the old map and before the
    change is known, is in a column of its own. Planning afresh is asked for a path that is at most 1 % longer than the
    one from planning again: its iterations are doubled until it has one.
    """
    lines = [
        "| field | goals | afresh ms (median / p95) | again ms | median of ratios | not prepared "
        "| length again / afresh | prepared in ms | points kept / bridged / left out |",
        "|---|--:|--:|--:|--:|--:|--:|--:|--:|",
    ]
    for size in sizes:
        for count in (1, 4):
            rows = []
            for seed in range(first, first + seeds):
                scene = random_scene(size, count, seed)
                changed = change(scene, share, seed)
                bare, _, _, _ = replanned(scene, changed, seed, repeats, prepared=False)
                new, again, ready, repair = replanned(scene, changed, seed, repeats, prepared=True)
                fresh, afresh = afresh_as_good(scene, changed, seed, again.length, repeats)
                if afresh.unreachable != again.unreachable:
                    raise AssertionError(f"seed {seed}: the two plans reach different goals")
                if afresh.ok:
                    rows.append((fresh, new, new / fresh, bare / fresh, again.length / afresh.length, ready,
                                 repair.kept, repair.rewired, repair.pruned))  # fmt: skip
            fresh_ms, new_ms, ratio, bare_ratio, lengths, ready_ms, *counts = (
                list(column) for column in zip(*rows, strict=True)
            )
            lines.append(
                f"| {size:g} m | {count} | {spread(fresh_ms, 2)} | {spread(new_ms, 2)} | {np.median(ratio):.2f} "
                f"| {np.median(bare_ratio):.2f} | {spread(lengths)} | {np.median(ready_ms):.0f} "
                f"| {' / '.join(f'{np.median(values):.0f}' for values in counts)} |"
            )
    return "\n".join(lines)


def replanned(
    scene: Scene, changed: NDArray[np.bool_], seed: int, repeats: int, *, prepared: bool
) -> tuple[float, PlanResult, float, Repair]:
    """Milliseconds, plan, milliseconds of preparing and repair of planning again on the changed map."""
    took, readied = [], []
    for _ in range(repeats):
        planner = Planner(robot_radius=RADIUS, seed=seed)
        field = scene.grid_field()
        planner.plan(field, scene.start, scene.goals)
        began = time.thread_time()
        if prepared:
            planner.prepare(field)
        readied.append(1e3 * (time.thread_time() - began))
        warm_up(scene, seed)
        ms, found = timed(partial(replan_changed, planner, scene, changed))
        took.append(ms)
    return min(took), found, min(readied), planner.repair


def warm_up(scene: Scene, seed: int) -> None:
    """A plan that nobody times."""
    plan(scene.grid_field(), scene.start, scene.goals, robot_radius=RADIUS, seed=seed)


def afresh_as_good(
    scene: Scene, changed: NDArray[np.bool_], seed: int, length: float, repeats: int
) -> tuple[float, PlanResult]:
    """Milliseconds and plan of the cheapest planning afresh that is at most 1 % longer than `length`, if one is."""
    best: tuple[float, PlanResult] | None = None
    for iterations in (None, 1500, 3000, 6000):
        took = []
        for _ in range(repeats):
            warm_up(scene, seed)
            ms, found = timed(partial(plan_changed, scene, changed, seed, iterations))
            took.append(ms)
        if best is None or found.length <= 1.01 * length:
            best = min(took), found
        if found.length <= 1.01 * length or not found.ok:
            break
    assert best is not None
    return best


def replan_changed(planner: Planner, scene: Scene, changed: NDArray[np.bool_]) -> PlanResult:
    """From the array of cells to the path, with what the planner holds."""
    return planner.plan(GridField(changed, RESOLUTION), scene.start, scene.goals)


def plan_changed(scene: Scene, changed: NDArray[np.bool_], seed: int, iterations: int | None) -> PlanResult:
    """From the array of cells to the path, with nothing known."""
    field = GridField(changed, RESOLUTION)
    algorithm = "multi-goal" if iterations is None else "best"
    return plan(
        field, scene.start, scene.goals, algorithm=algorithm, robot_radius=RADIUS, seed=seed, iterations=iterations
    )
