"""The planner: valid paths by an independent check, good ones, repeatable ones, and clear answers to bad questions."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from numpy.typing import NDArray
from rover.errors import BadInput
from rover.planning import ALGORITHMS, CircleField, GridField, PlanResult, plan

from companion.tests.planning import planning_field as paper


def nearest_circle(path: NDArray[np.float64], circles: list[list[float]], spacing: float = 0.002) -> float:
    """Least distance of densely sampled points of the path to any circle's rim: written apart from the planner."""
    worst = math.inf
    for a, b in itertools.pairwise(path):
        count = max(2, math.ceil(float(np.linalg.norm(b - a)) / spacing))
        points = a + np.linspace(0.0, 1.0, count)[:, None] * (b - a)
        for x, y, radius in circles:
            worst = min(worst, float(np.hypot(points[:, 0] - x, points[:, 1] - y).min()) - radius)
    return worst


def assert_visits(result: PlanResult, start: tuple[float, float], goals: list[tuple[float, float]]) -> None:
    assert tuple(result.path[0]) == start
    for goal, index in zip(result.order, result.goal_indices, strict=True):
        assert tuple(result.path[index]) == goals[goal]
    assert list(result.goal_indices) == sorted(result.goal_indices)


def random_blocks(seed: int) -> tuple[GridField, tuple[float, float], list[tuple[float, float]]]:
    """A grid of 10 × 10 m with square obstacles, a start, and two goals on free ground."""
    rng = np.random.default_rng(seed)
    blocked = np.zeros((200, 200), dtype=bool)
    for row, column in rng.integers(15, 170, (40, 2)):
        blocked[row : row + 15, column : column + 15] = True
    return GridField(blocked, 0.05), (0.4, 0.4), [(9.6, 9.6), (0.4, 9.6)]


@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize("iterations", [None, 500])
def test_paths_on_the_papers_field_touch_nothing_and_visit_both_goals_in_order(algorithm, iterations):
    for seed in range(12):
        result = plan(paper.field(), paper.START, paper.GOALS, algorithm=algorithm, seed=seed, iterations=iterations)
        assert result.ok
        assert result.order == (0, 1)
        assert_visits(result, paper.START, paper.GOALS)
        assert nearest_circle(result.path, paper.OBSTACLES) >= paper.RADIUS - 1e-6
        assert result.path.min() >= paper.RADIUS - 1e-6
        assert (result.path <= np.array([paper.WIDTH, paper.HEIGHT]) - paper.RADIUS + 1e-6).all()


def test_improved_tours_are_as_short_as_the_optimum_at_p95():
    lengths = [plan(paper.field(), paper.START, paper.GOALS, seed=s, iterations=200).length for s in range(50)]
    assert np.percentile(lengths, 95) <= 1.0005 * paper.OPTIMUM
    assert min(lengths) > 0.995 * paper.OPTIMUM  # shorter would mean cutting through something


def test_first_solutions_take_well_under_a_millisecond():
    times = [plan(paper.field(), paper.START, paper.GOALS, seed=s).first_solution_ms for s in range(50)]
    assert np.median(times) < 0.5  # 0.01 ms on the desk; the slack is for a busy machine


def test_the_same_seed_gives_the_same_path_and_another_seed_another():
    a, b, c = (
        plan(paper.field(), paper.START, paper.GOALS, algorithm="rrt", seed=s, iterations=400) for s in (3, 3, 4)
    )
    assert a.path.tobytes() == b.path.tobytes()
    assert (a.iterations, a.nodes) == (b.iterations, b.nodes)
    assert a.path.tobytes() != c.path.tobytes()


def test_a_time_budget_is_used_and_kept():
    results = [plan(paper.field(), paper.START, paper.GOALS, budget_ms=5.0) for _ in range(5)]
    assert all(result.time_ms >= 4.5 for result in results)
    assert min(result.time_ms for result in results) < 15.0  # the best of five: the machine may be busy
    assert all(result.length <= 1.01 * paper.OPTIMUM for result in results)


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_more_iterations_are_never_worse_for_one_seed(algorithm: str) -> None:
    for field, start, goals in ((paper.field(), paper.START, paper.GOALS), random_blocks(3)):
        for seed in range(4):
            lengths = [
                plan(field, start, goals, algorithm=algorithm, seed=seed, iterations=count).length
                for count in (None, 1, 20, 50, 150, 400, 1500)
            ]
            assert lengths == sorted(lengths, reverse=True)


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_more_time_is_never_worse_for_one_seed(algorithm: str) -> None:
    for field, start, goals in ((paper.field(), paper.START, paper.GOALS), random_blocks(3)):
        # Far apart, because the clock also runs when another process has the processor.
        lengths = [
            plan(field, start, goals, algorithm=algorithm, seed=1, budget_ms=budget).length
            for budget in (None, 0.0, 2.0, 200.0)
        ]
        assert lengths == sorted(lengths, reverse=True)


def test_a_budget_of_nothing_gives_the_plan_without_one() -> None:
    field, start, goals = random_blocks(7)
    for algorithm in ALGORITHMS:
        floor = plan(field, start, goals, algorithm=algorithm, seed=2)
        hurried = plan(field, start, goals, algorithm=algorithm, seed=2, budget_ms=0.0)
        assert hurried.path.tobytes() == floor.path.tobytes()


def test_every_algorithm_does_what_its_name_says() -> None:
    def names(algorithm: str, budget_ms: float | None = None) -> set[str]:
        result = plan(paper.field(), paper.START, paper.GOALS, algorithm=algorithm, seed=1, budget_ms=budget_ms)
        assert result.iterations == sum(stage.iterations for stage in result.stages)
        return {stage.name for stage in result.stages}

    assert names("rrt-star") == {"tree", "simplify"}
    assert names("rrt-star", budget_ms=10.0) == {"tree", "simplify", "rewiring"}
    assert names("rrt", budget_ms=10.0) == {"tree", "simplify"}
    assert names("goal-seeking", budget_ms=10.0) == {"tree", "simplify"}
    assert "lattice" not in names("multi-goal", budget_ms=10.0)
    assert {"tangents", "refine", "rrt-connect"} <= names("best", budget_ms=10.0)
    assert "rewiring" not in names("best", budget_ms=10.0)


def test_rrt_star_gets_better_by_rewiring_alone() -> None:
    def length(iterations: int) -> float:
        found = plan(paper.field(), paper.START, paper.GOALS, algorithm="rrt-star", seed=4, iterations=iterations)
        return found.length

    assert length(20_000) < 1.01 * paper.OPTIMUM
    assert length(20_000) < length(1)


def test_the_work_of_the_lattice_is_counted() -> None:
    blocked = np.zeros((120, 120), dtype=bool)
    blocked[60, :110] = True
    found = plan(GridField(blocked, 0.1), (1.0, 1.0), [(1.0, 11.0)], robot_radius=0.2)
    lattice = next(stage for stage in found.stages if stage.name == "lattice")
    assert lattice.iterations > 1000
    assert found.nodes > 1000


def test_a_corner_cost_buys_fewer_corners():
    free = plan(paper.field(), paper.START, paper.GOALS, iterations=1000)
    dear = plan(paper.field(), paper.START, paper.GOALS, iterations=1000, corner_cost_m=0.05)
    assert len(dear.path) < len(free.path)
    assert dear.length < 1.03 * free.length


def test_any_order_finds_the_shortest_open_tour():
    goals = [(3.6, 0.4), (1.2, 0.4), (2.8, 0.4), (2.0, 0.4)]
    result = plan(CircleField(4.0, 1.0), (0.4, 0.4), goals, any_order=True)
    assert result.order == (1, 3, 2, 0)
    assert result.length == pytest.approx(3.2, abs=1e-6)


def test_many_goals_in_any_order_are_all_visited_without_long_detours():
    rng = np.random.default_rng(5)
    goals = [tuple(p) for p in rng.uniform(0.3, 9.7, (30, 2)).tolist()]
    result = plan(CircleField(10.0, 10.0), (0.3, 0.3), goals, any_order=True, seed=1)
    assert sorted(result.order) == list(range(30))
    assert result.length < 55.0  # a random order takes about 150


def test_goals_that_cannot_be_reached_are_named_and_the_others_still_visited():
    wall = [[0.1 * i, 2.0, 0.1] for i in range(31)]
    goals = [(2.5, 1.0), (1.5, 3.0), (0.5, 1.5), (0.5, 2.0)]
    result = plan(CircleField(3.0, 4.0, wall), (0.5, 0.5), goals)
    assert result.status == "no_path"
    assert result.unreachable == (1, 3)
    assert result.order == (0, 2)
    assert_visits(result, (0.5, 0.5), goals)
    assert "goal 2 (1.5, 3): no way leads there" in result.reason
    assert "goal 4 (0.5, 2): nearer than 0.15 m" in result.reason
    assert nearest_circle(result.path, wall) >= 0.15 - 1e-6


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_an_enclosed_goal_is_given_up_by_every_algorithm(algorithm):
    ring = [[1.5 + 0.5 * math.cos(a), 1.5 + 0.5 * math.sin(a), 0.1] for a in np.arange(0.0, 6.28, 0.2)]
    result = plan(CircleField(3.0, 3.0, ring), (0.4, 0.4), [(1.5, 1.5)], algorithm=algorithm)
    assert result.status == "no_path"
    assert result.unreachable == (0,)
    assert len(result.path) == 1


def test_a_start_inside_an_obstacle_is_no_path_with_a_reason():
    result = plan(paper.field(), (2.0, 1.5), paper.GOALS)
    assert result.status == "no_path"
    assert result.unreachable == (0, 1)
    assert "the start (2, 1.5) is -0.200 m from the nearest obstacle" in result.reason


def test_a_start_slightly_too_near_an_obstacle_is_left_outward():
    field = CircleField(3.0, 3.0, [[1.0, 1.0, 0.2]])
    start = (1.33, 1.0)  # clearance 0.13 where 0.15 is needed
    assert not plan(field, start, [(0.4, 1.0)]).ok
    result = plan(field, start, [(0.4, 1.0)], start_recovery_m=0.1)
    assert result.ok
    assert tuple(result.path[0]) == start
    way_out = start + np.linspace(0.0, 1.0, 50)[:, None] * (result.path[1] - start)
    clearance = field.clearance(way_out)
    assert (np.diff(clearance) > -1e-9).all()
    assert np.linalg.norm(result.path[1] - start) <= 0.1
    assert nearest_circle(result.path[1:], [[1.0, 1.0, 0.2]]) >= 0.15 - 1e-6


def test_the_way_out_never_leads_deeper_in():
    field = CircleField(3.0, 3.0, [[1.0, 1.0, 0.2], [1.58, 1.0, 0.2]])
    # Between two circles 0.18 m apart clearance grows only sideways, and not within 5 cm to 0.15 m.
    assert not plan(field, (1.29, 1.0), [(2.5, 2.5)], start_recovery_m=0.05).ok


@pytest.mark.parametrize(
    ("start", "goals", "options", "message"),
    [
        ((math.nan, 0.5), [(2.0, 2.5)], {}, "the start must be two finite numbers"),
        ((2.0, 0.5), [(math.inf, 2.5)], {}, "goal 1 must be two finite numbers"),
        ((2.0, 0.5), [(2.0, 2.5), (5.0, 1.0)], {}, "goal 2 .* lies outside the map"),
        ((-1.0, 0.5), [(2.0, 2.5)], {}, "the start .* lies outside the map"),
        ((2.0, 0.5), [], {}, "no goal given"),
        ((2.0, 0.5), [(2.0, 2.5)], {"algorithm": "prm"}, "unknown algorithm 'prm'"),
        ((2.0, 0.5), [(2.0, 2.5)], {"robot_radius": math.nan}, "the robot's radius"),
        ((2.0, 0.5), [(2.0, 2.5)], {"robot_radius": -0.1}, "the robot's radius"),
        ((2.0, 0.5), [(2.0, 2.5)], {"budget_ms": math.nan}, "the time budget"),
        ((2.0, 0.5), [(2.0, 2.5)], {"iterations": 0}, "iterations must be at least 1"),
        ((2.0, 0.5), [(2.0, 2.5)], {"step_m": 0.0}, "the step must be"),
        ((2.0, 0.5), [(2.0, 2.5)], {"goal_bias": 1.5}, "the goal bias"),
    ],
)
def test_questions_without_sense_get_one_clear_line(start, goals, options, message):
    with pytest.raises(BadInput, match=message) as caught:
        plan(paper.field(), start, goals, **options)
    assert "\n" not in str(caught.value)


def test_odd_but_valid_questions_are_answered():
    empty = CircleField(3.0, 4.0)
    here = plan(empty, (1.0, 1.0), [(1.0, 1.0)])
    assert here.ok
    assert here.length == 0.0
    twice = plan(empty, (1.0, 1.0), [(2.0, 2.0), (2.0, 2.0)])
    assert twice.ok
    assert twice.length == pytest.approx(math.sqrt(2.0))
    too_wide = plan(empty, (1.0, 1.0), [(2.0, 2.0)], robot_radius=2.5)
    assert too_wide.status == "no_path"
    hundred = plan(empty, (1.0, 1.0), [(0.2 + 0.026 * i, 2.0) for i in range(100)])
    assert len(hundred.order) == 100


def test_a_grid_path_keeps_its_distance_from_blocked_squares():
    rng = np.random.default_rng(2)
    blocked = rng.random((60, 80)) < 0.06
    blocked[:6, :6] = blocked[-6:, -6:] = False
    field = GridField(blocked, 0.05, (-1.0, 2.0))
    result = plan(field, (-0.87, 2.13), [(2.87, 4.87)], robot_radius=0.06, seed=3, iterations=500)
    assert result.ok
    rows, columns = np.nonzero(blocked)
    low = np.stack([columns, rows], axis=1) * 0.05 + (-1.0, 2.0)
    for a, b in itertools.pairwise(result.path):
        for t in np.linspace(0.0, 1.0, 200):
            p = a + t * (b - a)
            gap = np.maximum(np.maximum(low - p, p - low - 0.05), 0.0)
            assert np.hypot(gap[:, 0], gap[:, 1]).min() >= 0.06 - 1e-6


def test_a_grid_with_a_closed_wall_has_no_path_and_with_a_gap_one():
    blocked = np.zeros((100, 100), dtype=bool)
    blocked[50, :] = True
    assert not plan(GridField(blocked, 0.02), (1.0, 0.5), [(1.0, 1.6)], robot_radius=0.05).ok
    blocked[50, 80:87] = False  # 14 cm wide for a robot of 10 cm
    result = plan(GridField(blocked, 0.02), (1.0, 0.5), [(1.0, 1.6)], robot_radius=0.05)
    assert result.ok
    assert result.length > 1.5
