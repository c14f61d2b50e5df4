"""Planning again: valid on the new map, as good as planning afresh, repeatable, and cheap because the tree is kept."""

from __future__ import annotations

import numpy as np
import pytest
from rover.errors import BadInput
from rover.planning import CircleField, Field, GridField, Planner, PlanResult, plan

from companion.tests.planning import planning_field as paper


def assert_valid(result: PlanResult, field: Field, goals: list[tuple[float, float]], radius: float) -> None:
    for a, b in zip(result.path[:-1], result.path[1:], strict=True):
        assert field.segment_clear(tuple(a), tuple(b), radius)
    for goal, index in zip(result.order, result.goal_indices, strict=True):
        assert tuple(result.path[index]) == goals[goal]


def grid(rng: np.random.Generator) -> np.ndarray:
    blocked = np.zeros((120, 120), dtype=bool)
    for row, column in rng.integers(10, 100, (26, 2)):
        blocked[row : row + 8, column : column + 8] = True
    return blocked


def test_the_first_plan_is_the_same_as_without_memory():
    afresh = plan(paper.field(), paper.START, paper.GOALS, seed=5, iterations=300)
    kept = Planner(seed=5).plan(paper.field(), paper.START, paper.GOALS, iterations=300)
    assert kept.path.tobytes() == afresh.path.tobytes()


@pytest.mark.parametrize("any_order", [False, True])
def test_after_every_change_of_the_map_paths_are_valid_and_reach_what_planning_afresh_reaches(any_order):
    rng = np.random.default_rng(3)
    goals = [(5.7, 5.7), (0.3, 5.7), (5.7, 0.3)]
    planner = Planner(robot_radius=0.1, seed=1, any_order=any_order)
    ratios = []
    for _ in range(25):
        field = GridField(grid(rng), 0.05)
        goals_now = [*goals, (float(rng.uniform(0.2, 5.8)), 0.2)]
        again = planner.plan(field, (0.3, 0.3), goals_now, iterations=300)
        afresh = plan(field, (0.3, 0.3), goals_now, robot_radius=0.1, any_order=any_order, iterations=300)
        assert again.unreachable == afresh.unreachable
        assert_valid(again, field, goals_now, 0.1)
        ratios.append(again.length / afresh.length)
    assert np.median(ratios) < 1.01
    assert max(ratios) < 1.25


def test_an_unchanged_map_keeps_the_whole_tree():
    planner = Planner(seed=2)
    first = planner.plan(paper.field(), paper.START, paper.GOALS)
    second = planner.plan(paper.field(), paper.START, paper.GOALS)
    assert planner.repair.pruned == 0
    assert planner.repair.kept >= 3
    assert second.iterations == 0
    assert second.length <= first.length + 1e-9


def test_a_cut_branch_is_pruned_or_rewired_and_the_new_path_goes_around():
    planner = Planner(robot_radius=0.1, seed=4)
    corridor = [(0.05, 1.0 + 0.1 * i, 0.05) for i in range(3)]
    open_field = CircleField(4.0, 3.0, corridor)
    planner.plan(open_field, (0.5, 1.5), [(3.5, 1.5)])
    wall = CircleField(4.0, 3.0, [*corridor, *((2.0, 0.1 * i, 0.06) for i in range(26))])
    result = planner.plan(wall, (0.5, 1.5), [(3.5, 1.5)])
    assert result.ok
    assert_valid(result, wall, [(3.5, 1.5)], 0.1)
    assert result.length > 3.5
    closed = CircleField(4.0, 3.0, [*corridor, *((2.0, 0.1 * i, 0.06) for i in range(31))])
    assert planner.plan(closed, (0.5, 1.5), [(3.5, 1.5)]).unreachable == (0,)
    back = planner.plan(open_field, (0.5, 1.5), [(3.5, 1.5)])
    assert back.ok
    assert back.length == pytest.approx(3.0, abs=1e-6)


def test_the_start_may_move_along_the_path():
    planner = Planner(seed=6)
    result = planner.plan(paper.field(), paper.START, paper.GOALS, iterations=300)
    on_the_way = tuple(result.path[0] + 0.5 * (result.path[1] - result.path[0]))
    rest = planner.plan(paper.field(), on_the_way, paper.GOALS)
    assert tuple(rest.path[0]) == on_the_way
    assert planner.repair.kept > 0
    assert rest.length < result.length


def test_the_same_calls_give_the_same_bytes():
    def run() -> list[bytes]:
        planner = Planner(robot_radius=0.1, seed=9, any_order=True)
        rng = np.random.default_rng(1)
        goals = [(5.7, 5.7), (0.3, 5.7), (5.7, 0.3)]
        fields = [GridField(grid(rng), 0.05) for _ in range(3)]
        return [planner.plan(field, (0.3, 0.3), goals, iterations=200).path.tobytes() for field in fields]

    assert run() == run()


def test_questions_without_sense_get_one_clear_line():
    with pytest.raises(BadInput, match="the robot's radius"):
        Planner(robot_radius=-1.0)
    with pytest.raises(BadInput, match="no goal given"):
        Planner().plan(paper.field(), paper.START, [])


def cluttered(rng: np.random.Generator) -> np.ndarray:
    """8 × 8 m with a fifth of it under blocks of 0.4 m."""
    blocked = np.zeros((160, 160), dtype=bool)
    while blocked.mean() < 0.2:
        row, column = rng.integers(0, 152, 2)
        blocked[row : row + 8, column : column + 8] = True
    return blocked


def patched(blocked: np.ndarray, rng: np.random.Generator, patches: int = 12) -> np.ndarray:
    """The same with squares of 0.3 to 0.8 m set or cleared."""
    changed = blocked.copy()
    for number in range(patches):
        side = int(rng.integers(6, 17))
        row, column = rng.integers(0, 160 - side, 2)
        changed[row : row + side, column : column + side] = number % 2 == 0
    return np.asarray(changed)


def free_of_obstacles(blocked: np.ndarray, points: list[tuple[float, float]]) -> np.ndarray:
    cleared = blocked.copy()
    for x, y in points:
        row, column = int(y / 0.05), int(x / 0.05)
        cleared[max(row - 5, 0) : row + 6, max(column - 5, 0) : column + 6] = False
    return np.asarray(cleared)


def test_a_tour_repaired_where_patches_of_the_map_changed_is_as_short_as_one_planned_afresh():
    start, goals = (0.4, 0.4), [(7.5, 7.5), (0.5, 7.4), (7.4, 0.6)]
    ratios, bridged = [], 0
    for seed in range(25):
        rng = np.random.default_rng(seed)
        ground = free_of_obstacles(cluttered(rng), [start, *goals])
        planner = Planner(robot_radius=0.1, seed=seed)
        planner.plan(GridField(ground, 0.05), start, goals)
        for _ in range(3):
            ground = free_of_obstacles(patched(ground, rng), [start, *goals])
            field = GridField(ground, 0.05)
            again = planner.plan(field, start, goals)
            afresh = plan(field, start, goals, robot_radius=0.1, seed=seed, algorithm="multi-goal")
            # A way that is kept may lead through a passage that is finer than what a search from nothing finds.
            assert set(again.unreachable) <= set(afresh.unreachable)
            assert_valid(again, field, goals, 0.1)
            bridged += planner.repair.rewired
            if afresh.ok:
                ratios.append(again.length / afresh.length)
    assert bridged > 50
    assert len(ratios) > 30
    assert np.median(ratios) < 1.03
    assert np.percentile(ratios, 95) < 1.2


def test_a_passage_that_closes_and_opens_again_is_named_and_then_used_again():
    ground = np.zeros((160, 160), dtype=bool)
    ground[80] = True
    ground[80, 100:110] = False  # 0.5 m wide for a robot of 0.2 m
    planner = Planner(robot_radius=0.1, seed=0)
    first = planner.plan(GridField(ground, 0.05), (1.0, 1.0), [(1.0, 7.0)])
    closed = ground.copy()
    closed[80] = True
    assert planner.plan(GridField(closed, 0.05), (1.0, 1.0), [(1.0, 7.0)]).unreachable == (0,)
    again = planner.plan(GridField(ground, 0.05), (1.0, 1.0), [(1.0, 7.0)])
    assert again.length < 1.02 * first.length
