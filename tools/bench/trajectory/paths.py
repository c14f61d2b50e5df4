"""Paths of many kinds, as they come from planners, files and hands: each a function of a seed.

None of them was used to choose a number in rover.motion.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from rover.planning.fields import CircleField, GridField
from rover.planning.planner import plan
from rover.vehicle import STANDARD

Array = NDArray[np.float64]

ROBOT_RADIUS_M = STANDARD.radius


@dataclass(frozen=True, eq=False)
class Case:
    """`path` (N, 2) in metres; `tolerance`: how far curves may be off; the map that it was planned on; `shape` (M, 2):
    the smooth shape that the path was sampled from, finely, where there is one."""

    path: Array
    tolerance: float = 0.05
    field: CircleField | GridField | None = None
    shape: Array | None = None


def _walk(rng: np.random.Generator, count: int, short: float, long: float, turn: float) -> Array:
    headings = np.cumsum(rng.normal(0.0, turn, count))
    steps = rng.uniform(short, long, count)[:, None] * np.column_stack([np.cos(headings), np.sin(headings)])
    return np.vstack([np.zeros(2), np.cumsum(steps, axis=0)])


def _sampled(shape: Array, spacing: float) -> Array:
    """Points of a finely sampled shape at equal distances along it, its ends among them."""
    steps = np.diff(shape, axis=0)
    way = np.concatenate([[0.0], np.cumsum(np.hypot(steps[:, 0], steps[:, 1]))])
    at = np.linspace(0.0, way[-1], max(2, round(way[-1] / spacing) + 1))
    return np.column_stack([np.interp(at, way, shape[:, 0]), np.interp(at, way, shape[:, 1])])


def open_legs(rng: np.random.Generator) -> Case:
    """Legs of 0.3 to 1.5 m, corners of any angle, a tolerance of 2 to 20 cm."""
    return Case(_walk(rng, int(rng.integers(3, 13)), 0.3, 1.5, 1.0), float(rng.uniform(0.02, 0.2)))


def short_legs(rng: np.random.Generator) -> Case:
    """Legs of 2 to 30 cm."""
    return Case(_walk(rng, int(rng.integers(10, 60)), 0.02, 0.3, 0.6), float(rng.uniform(0.02, 0.1)))


def long_walk(rng: np.random.Generator) -> Case:
    """500 to 2,000 corners."""
    return Case(_walk(rng, int(rng.integers(500, 2000)), 0.1, 0.6, 0.7))


def between_circles(rng: np.random.Generator) -> Case:
    """A tour over three goals between 25 circles on 5 m × 5 m, as `rover plan` gives it."""
    while True:
        centres = rng.uniform(0.2, 4.8, (25, 2))
        circles = np.column_stack([centres, rng.uniform(0.08, 0.3, 25)])
        field = CircleField(5.0, 5.0, circles.tolist())
        free = rng.uniform(0.2, 4.8, (60, 2))
        free = free[field.clearance(free) > ROBOT_RADIUS_M + 0.02]
        if len(free) < 4:
            continue
        goals = [(float(x), float(y)) for x, y in free[1:4]]
        start = (float(free[0, 0]), float(free[0, 1]))
        found = plan(field, start, goals, robot_radius=ROBOT_RADIUS_M, seed=int(rng.integers(2**31)))
        if found.ok and len(found.path) > 1:
            return Case(found.path, 0.3, field)


def raw_tree(rng: np.random.Generator) -> Case:
    """A path as a plain RRT leaves it, steps of 0.1 to 0.4 m, between 12 circles."""
    while True:
        circles = np.column_stack([rng.uniform(0.5, 5.5, (12, 2)), rng.uniform(0.1, 0.4, 12)])
        field = CircleField(6.0, 6.0, circles.tolist())
        step = float(rng.uniform(0.1, 0.4))
        nodes, parents = [(0.3, 0.3)], [-1]
        if field.clearance(np.array(nodes))[0] < ROBOT_RADIUS_M + 0.01:
            continue
        for _ in range(3000):
            target = rng.uniform(0.2, 5.8, 2) if rng.random() > 0.1 else np.array([5.6, 5.6])
            apart = np.hypot(*(np.array(nodes) - target).T)
            near = int(np.argmin(apart))
            here = np.array(nodes[near])
            there = here + (target - here) * min(1.0, step / max(float(apart[near]), 1e-9))
            if not field.segment_clear(nodes[near], (float(there[0]), float(there[1])), ROBOT_RADIUS_M + 0.003):
                continue
            nodes.append((float(there[0]), float(there[1])))
            parents.append(near)
            if math.dist(nodes[-1], (5.6, 5.6)) < step:
                break
        else:
            continue
        chain = [len(nodes) - 1]
        while parents[chain[-1]] >= 0:
            chain.append(parents[chain[-1]])
        return Case(np.array([nodes[number] for number in reversed(chain)]), 0.3, field)


def grid_search(rng: np.random.Generator) -> Case:
    """Cell by cell, as A* with eight neighbours gives it, over cells of 1 to 10 cm, a quarter of them blocked."""
    while True:
        cell, side = float(rng.choice([0.01, 0.02, 0.05, 0.1])), 60
        coarse = rng.random((side // 6, side // 6)) < 0.2
        blocked = np.kron(coarse, np.ones((6, 6), dtype=bool)).astype(bool)
        found = _grid_path(blocked, (0, 0), (side - 1, side - 1))
        if found is not None:
            return Case((np.array(found) + 0.5)[:, ::-1] * cell, max(cell, 0.02))


def _grid_path(
    blocked: NDArray[np.bool_], start: tuple[int, int], goal: tuple[int, int]
) -> list[tuple[int, int]] | None:
    if blocked[start] or blocked[goal]:
        return None
    moves = [(r, c) for r in (-1, 0, 1) for c in (-1, 0, 1) if (r, c) != (0, 0)]
    cost, parent, queue = {start: 0.0}, {start: start}, [(0.0, start)]
    while queue:
        _, here = heapq.heappop(queue)
        if here == goal:
            chain = [goal]
            while chain[-1] != start:
                chain.append(parent[chain[-1]])
            return chain[::-1]
        for r, c in moves:
            there = (here[0] + r, here[1] + c)
            inside = 0 <= there[0] < blocked.shape[0] and 0 <= there[1] < blocked.shape[1]
            if not inside or blocked[there] or blocked[here[0] + r, here[1]] or blocked[here[0], here[1] + c]:
                continue
            total = cost[here] + math.hypot(r, c)
            if total < cost.get(there, math.inf) - 1e-12:
                cost[there], parent[there] = total, here
                heapq.heappush(queue, (total + math.dist(there, goal), there))
    return None


def mower(rng: np.random.Generator) -> Case:
    """20 to 300 rows of 2 to 6 m, 0.2 to 0.6 m apart."""
    rows, width, gap = int(rng.integers(20, 300)), float(rng.uniform(2.0, 6.0)), float(rng.uniform(0.2, 0.6))
    y = np.repeat(np.arange(rows) * gap, 2)
    x = np.tile([0.0, width, width, 0.0], (rows + 1) // 2)[: 2 * rows]
    return Case(np.column_stack([x, y]))


def drawn(rng: np.random.Generator) -> Case:
    """A track drawn by hand: a smooth line sampled unevenly, a few millimetres of tremor."""
    shape = _spline(rng.uniform(0.0, 4.0, (int(rng.integers(4, 9)), 2)))
    path = _sampled(shape, float(rng.uniform(0.01, 0.05)))
    path = path[np.sort(rng.choice(len(path), max(3, int(0.7 * len(path))), replace=False))]
    return Case(path + rng.normal(0.0, float(rng.uniform(0.0005, 0.004)), path.shape))


def _spline(points: Array) -> Array:
    """Catmull-Rom through the points, 200 places a span."""
    padded = np.vstack([2 * points[0] - points[1], points, 2 * points[-1] - points[-2]])
    t = np.linspace(0.0, 1.0, 200, endpoint=False)[:, None]
    spans = []
    for a, b, c, d in zip(padded[:-3], padded[1:-2], padded[2:-1], padded[3:], strict=True):
        spans.append(0.5 * (2 * b + t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * b - a - 3 * c + d)))))
    return np.vstack([*spans, points[-1:]])


def spline(rng: np.random.Generator) -> Case:
    """A smooth line sampled every 0.1 to 8 cm."""
    shape = _spline(rng.uniform(0.0, 5.0, (int(rng.integers(4, 8)), 2)))
    return Case(_sampled(shape, float(np.exp(rng.uniform(math.log(0.001), math.log(0.08))))))


def spiral(rng: np.random.Generator) -> Case:
    """Inward, two to five turns, sampled every 0.1 to 5 cm."""
    turns, outer = float(rng.uniform(2.0, 5.0)), float(rng.uniform(0.8, 2.5))
    angle = np.linspace(0.0, 2.0 * math.pi * turns, 20_000)
    radius = np.linspace(outer, float(rng.uniform(0.3, 0.5)), len(angle))
    shape = np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])
    return Case(_sampled(shape, float(np.exp(rng.uniform(math.log(0.001), math.log(0.05))))), 0.05, None, shape)


def circle(rng: np.random.Generator) -> Case:
    """Radius 0.3 to 3 m, a half to two turns, sampled every 0.1 mm to 3 cm."""
    radius, turns = float(rng.uniform(0.3, 3.0)), float(rng.uniform(0.5, 2.0))
    angle = np.linspace(0.0, 2.0 * math.pi * turns, 20_000)
    shape = radius * np.column_stack([np.cos(angle), np.sin(angle)])
    return Case(_sampled(shape, _spacing(rng)), 0.05, None, shape)


def sine(rng: np.random.Generator) -> Case:
    """Waves of 0.8 to 3 m, 5 to 60 cm high, sampled every 0.1 mm to 3 cm."""
    wave, height = float(rng.uniform(0.8, 3.0)), float(rng.uniform(0.05, 0.6))
    x = np.linspace(0.0, float(rng.uniform(2.0, 4.0)) * wave, 20_000)
    shape = np.column_stack([x, height * np.sin(2.0 * math.pi * x / wave)])
    return Case(_sampled(shape, _spacing(rng)), 0.05, None, shape)


def line(rng: np.random.Generator) -> Case:
    """0.5 to 8 m, in any direction, sampled every 0.1 mm to 3 cm."""
    angle, length = float(rng.uniform(0.0, 2.0 * math.pi)), float(rng.uniform(0.5, 8.0))
    shape = np.linspace(0.0, length, 20_000)[:, None] * np.array([math.cos(angle), math.sin(angle)])
    return Case(_sampled(shape, _spacing(rng)), 0.05, None, shape)


def _spacing(rng: np.random.Generator) -> float:
    return float(rng.choice([1e-4, 1e-3, 6e-3, 1e-2, 1.7e-2, 3e-2]))


KINDS: dict[str, Callable[[np.random.Generator], Case]] = {
    "open, legs from 0.3 m": open_legs,
    "planned between circles": between_circles,
    "raw RRT": raw_tree,
    "mower": mower,
    "short legs, 2 to 30 cm": short_legs,
    "long walk": long_walk,
    "grid A*": grid_search,
    "spline": spline,
    "drawn by hand": drawn,
    "spiral": spiral,
    "circle": circle,
    "sine": sine,
    "line": line,
}
