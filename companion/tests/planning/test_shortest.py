"""Plans without a budget are near the shortest path on every kind of map, and lead through passages that just fit."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator

import numpy as np
import pytest
from numpy.typing import NDArray
from rover.planning import CircleField, Field, GridField, plan

Point = tuple[float, float]
RADIUS = 0.15


def assert_clear(field: Field, path: NDArray[np.float64], radius: float) -> None:
    for a, b in itertools.pairwise(path):
        assert field.segment_clear((a[0], a[1]), (b[0], b[1]), radius)


def wall_with_gate(gap: float, seed: int) -> CircleField:
    """A wall of circles across 6 × 6 m with one gate that is `gap` metres wide, and clutter on both sides."""
    rng = np.random.default_rng(seed)
    x = float(rng.uniform(1.5, 4.5))
    circles = [[x - 0.5 * gap - 0.2, 3.0, 0.2], [x + 0.5 * gap + 0.2, 3.0, 0.2]]
    circles += [[x - 0.5 * gap - 0.2 - 0.3 * i, 3.0, 0.2] for i in range(1, 20)]
    circles += [[x + 0.5 * gap + 0.2 + 0.3 * i, 3.0, 0.2] for i in range(1, 20)]
    for cx, cy in rng.uniform((0.5, 0.8), (5.5, 5.2), (12, 2)):
        if abs(cy - 3.0) > 1.0:
            circles.append([float(cx), float(cy), 0.15])
    return CircleField(6.0, 6.0, circles)


@pytest.mark.parametrize("excess_mm", [0.2, 2.6, 20.0])
def test_a_gate_a_little_wider_than_the_disc_is_found_within_50_ms(excess_mm: float) -> None:
    for seed in range(4):
        field = wall_with_gate(2.0 * RADIUS + 1e-3 * excess_mm, seed)
        found = plan(field, (3.0, 0.4), [(3.0, 5.6)], robot_radius=RADIUS, seed=seed, budget_ms=50.0)
        assert found.ok
        assert found.first_solution_ms is not None
        assert found.first_solution_ms < 50.0
        assert_clear(field, found.path, RADIUS)


def test_a_gate_narrower_than_the_disc_is_no_path() -> None:
    field = wall_with_gate(2.0 * RADIUS - 1e-4, 1)
    found = plan(field, (3.0, 0.4), [(3.0, 5.6)], robot_radius=RADIUS)
    assert not found.ok
    assert "no way leads there" in found.reason


def test_a_gate_that_is_shorter_than_the_way_around_is_taken_without_a_budget() -> None:
    # Two posts whose gap is 2.6 mm wider than the disc, and walls that are long to go around.
    gap = 2.0 * RADIUS + 0.0026
    posts = [[3.0 + side * (0.5 * gap + 0.2 + 0.3 * i), 3.0, 0.2] for side in (-1, 1) for i in range(7)]
    field = CircleField(6.0, 6.0, posts)
    found = plan(field, (3.0, 0.5), [(3.2, 5.5)], robot_radius=RADIUS)
    assert found.length < 1.01 * math.hypot(0.2, 5.0)


def around_circles(field: CircleField, start: Point, goal: Point, radius: float) -> float:
    """The shortest path over a dense visibility graph: 48 points just outside each rim, Dijkstra's search."""
    angles = np.arange(48) * 2.0 * math.pi / 48
    rims = [
        (
            x + (r + radius) / math.cos(math.pi / 48) * math.cos(a),
            y + (r + radius) / math.cos(math.pi / 48) * math.sin(a),
        )
        for x, y, r in field.obstacles.tolist()
        for a in angles
    ]
    nodes = [start, goal, *(p for p in rims if field.segment_clear(p, p, radius))]
    cost = [math.inf] * len(nodes)
    cost[0], done = 0.0, [False] * len(nodes)
    while True:
        at = min((i for i in range(len(nodes)) if not done[i]), key=cost.__getitem__)
        if at == 1:
            return cost[1]
        done[at] = True
        for i, node in enumerate(nodes):
            length = cost[at] + math.dist(nodes[at], node)
            if not done[i] and length < cost[i] and field.segment_clear(nodes[at], node, radius):
                cost[i] = length


@pytest.mark.parametrize("seed", range(5))
def test_among_circles_the_plan_is_the_shortest_path(seed: int) -> None:
    rng = np.random.default_rng(seed)
    circles = np.column_stack([rng.uniform(0.8, 5.2, (9, 2)), rng.uniform(0.15, 0.7, 9)])
    field = CircleField(6.0, 6.0, circles.tolist())
    found = plan(field, (0.3, 0.3), [(5.7, 5.7)], robot_radius=RADIUS, seed=seed)
    assert found.ok
    assert_clear(field, found.path, RADIUS)
    assert found.length <= 1.002 * around_circles(field, (0.3, 0.3), (5.7, 5.7), RADIUS)


def mazes() -> Iterator[NDArray[np.bool_]]:
    for seed in range(3):
        rng = np.random.default_rng(seed)
        blocked = np.zeros((121, 121), dtype=bool)
        for row in range(12, 120, 12):
            blocked[row] = True
            door = int(rng.integers(2, 110))
            blocked[row, door : door + 4] = False
        yield blocked
    for share in (0.1, 0.25):
        yield np.random.default_rng(9).random((121, 121)) < share


def test_on_grids_the_plan_is_within_five_percent_of_what_long_planning_finds() -> None:
    ratios = []
    for number, blocked in enumerate(mazes()):
        blocked[:3, :3] = blocked[-3:, -3:] = False
        field = GridField(blocked, 1.0)
        found = plan(field, (1.5, 1.5), [(119.5, 119.5)], robot_radius=0.3, seed=number)
        long = plan(field, (1.5, 1.5), [(119.5, 119.5)], robot_radius=0.3, seed=number, iterations=3000)
        assert found.ok == long.ok
        if found.ok:
            assert_clear(field, found.path, 0.3)
            ratios.append(found.length / long.length)
    assert len(ratios) >= 4
    assert max(ratios) < 1.05


def test_nothing_passes_between_squares_that_share_a_corner() -> None:
    for size in (6, 9, 14):
        blocked = np.eye(size, dtype=bool)
        found = plan(GridField(blocked, 1.0), (0.5, size - 0.5), [(size - 0.5, 0.5)], robot_radius=0.0)
        assert not found.ok
        blocked[size // 2, size // 2] = False
        found = plan(GridField(blocked, 1.0), (0.5, size - 0.5), [(size - 0.5, 0.5)], robot_radius=0.0)
        assert found.ok


def test_a_start_or_a_goal_in_collision_is_said_with_its_place_and_distance() -> None:
    blocked = np.zeros((20, 20), dtype=bool)
    blocked[8:12, 8:12] = True
    field = GridField(blocked, 0.1)
    inside = plan(field, (1.0, 1.0), [(0.3, 0.3)], robot_radius=0.1)
    assert "the start (1, 1) is" in inside.reason
    assert "the robot needs 0.1 m" in inside.reason
    at_goal = plan(field, (0.3, 0.3), [(1.0, 1.0)], robot_radius=0.1)
    assert at_goal.reason == "goal 1 (1, 1): nearer than 0.1 m to an obstacle or wall"
