"""Planning again over a roadmap of prepared ground: valid, as short as planning afresh, repeatable, complete."""

from __future__ import annotations

import numpy as np
from rover.planning import CircleField, Field, GridField, Planner, PlanResult, plan

from companion.tests.planning import planning_field as paper

RADIUS = 0.15
RESOLUTION = 0.05
CELLS = 200
START = (0.5, 0.5)
GOALS = [(9.5, 9.5), (0.5, 9.5), (9.5, 0.5)]


def cluttered(rng: np.random.Generator, patches: int, side: tuple[int, int], value: bool, ground: np.ndarray) -> None:
    """Sets squares of the ground to `value`, but not where the start and the goals are."""
    for _ in range(patches):
        size = int(rng.integers(*side))
        row, column = rng.integers(0, CELLS - size, 2)
        ground[row : row + size, column : column + size] = value
    for x, y in (START, *GOALS):
        row, column = int(y / RESOLUTION), int(x / RESOLUTION)
        ground[max(row - 6, 0) : row + 7, max(column - 6, 0) : column + 7] = False


def assert_valid(found: PlanResult, field: Field, goals: list[tuple[float, float]]) -> None:
    for a, b in zip(found.path[:-1], found.path[1:], strict=True):
        assert field.segment_clear(tuple(a), tuple(b), RADIUS)
    assert tuple(found.path[0]) == START
    for goal, index in zip(found.order, found.goal_indices, strict=True):
        assert tuple(found.path[index]) == goals[goal]


def changed_grounds(seed: int, times: int) -> list[GridField]:
    """A cluttered ground, and what becomes of it when patches of it are blocked and others freed."""
    rng = np.random.default_rng(seed)
    ground = np.zeros((CELLS, CELLS), dtype=bool)
    cluttered(rng, 40, (8, 22), True, ground)
    fields = [GridField(ground.copy(), RESOLUTION)]
    for _ in range(times):
        cluttered(rng, 10, (4, 18), True, ground)
        cluttered(rng, 6, (4, 18), False, ground)
        fields.append(GridField(ground.copy(), RESOLUTION))
    return fields


def test_ways_over_the_roadmap_are_valid_and_about_as_short_as_afresh_and_name_the_same_goals():
    ratios, bridged = [], 0
    for seed in range(12):
        old, *new = changed_grounds(seed, 3)
        planner = Planner(robot_radius=RADIUS, seed=seed)
        planner.plan(old, START, GOALS)
        planner.prepare(old)
        for number, field in enumerate(new):
            again = planner.plan(field, START, GOALS)
            afresh = plan(field, START, GOALS, robot_radius=RADIUS, seed=seed, algorithm="multi-goal")
            assert_valid(again, field, GOALS)
            # A way that is kept may lead through a passage that is finer than what a search from nothing finds.
            assert set(again.unreachable) <= set(afresh.unreachable)
            bridged += planner.repair.rewired
            if afresh.ok:
                ratios.append(again.length / afresh.length)
            if number == 1:
                planner.prepare(field)
    assert bridged > 20
    assert len(ratios) > 12
    assert np.median(ratios) < 1.02
    assert max(ratios) < 1.3


def test_a_way_far_around_is_found_without_a_search_over_the_map():
    ground = np.zeros((CELLS, CELLS), dtype=bool)
    ground[100, 20:] = True
    ground[100, 150:162] = False
    goal = [(8.0, 9.0)]
    planner = Planner(robot_radius=RADIUS, seed=0)
    planner.plan(GridField(ground, RESOLUTION), START, goal)
    planner.prepare(GridField(ground, RESOLUTION))
    ground[100, 150:162] = True
    closed = GridField(ground, RESOLUTION)
    again = planner.plan(closed, START, goal)
    assert again.ok
    assert planner.repair.rewired >= 1
    assert_valid(again, closed, goal)
    assert again.length < 1.03 * plan(closed, START, goal, robot_radius=RADIUS, iterations=3000).length


def test_a_goal_that_is_walled_in_is_named_and_found_again_when_the_wall_falls():
    ground = np.zeros((CELLS, CELLS), dtype=bool)
    planner = Planner(robot_radius=RADIUS, seed=3)
    planner.plan(GridField(ground, RESOLUTION), START, GOALS)
    planner.prepare(GridField(ground, RESOLUTION))
    walled = ground.copy()
    walled[170, 170:] = walled[170:, 170] = True
    assert planner.plan(GridField(walled, RESOLUTION), START, GOALS).unreachable == (0,)
    assert planner.plan(GridField(ground, RESOLUTION), START, GOALS).ok


def test_a_start_that_moves_and_a_goal_that_is_new_need_no_new_roadmap():
    old, new = changed_grounds(5, 1)
    planner = Planner(robot_radius=RADIUS, seed=5, any_order=True)
    first = planner.plan(old, START, GOALS)
    planner.prepare(old)
    on_the_way = tuple(0.5 * (first.path[0] + first.path[1]))
    goals = [*GOALS[:2], (9.5, 5.0)]
    if new.segment_clear(on_the_way, on_the_way, RADIUS):
        again = planner.plan(new, on_the_way, goals)
        assert tuple(again.path[0]) == on_the_way
        for a, b in zip(again.path[:-1], again.path[1:], strict=True):
            assert new.segment_clear(tuple(a), tuple(b), RADIUS)


def test_the_same_calls_give_the_same_bytes():
    def run() -> list[bytes]:
        planner = Planner(robot_radius=RADIUS, seed=9)
        paths = []
        for field in changed_grounds(7, 4):
            paths.append(planner.plan(field, START, GOALS).path.tobytes())
            planner.prepare(field)
        return paths

    assert run() == run()


def test_preparing_changes_no_plan_on_an_unchanged_map_and_works_before_any_plan():
    field = changed_grounds(2, 0)[0]
    plain, ready = Planner(robot_radius=RADIUS, seed=1), Planner(robot_radius=RADIUS, seed=1)
    ready.prepare(field)
    for planner in (plain, ready):
        planner.plan(field, START, GOALS)
    ready.prepare(field)
    assert ready.plan(field, START, GOALS).path.tobytes() == plain.plan(field, START, GOALS).path.tobytes()


def test_the_roadmap_of_a_large_map_stays_small():
    nodes, edges = Planner(robot_radius=RADIUS).prepare(GridField(np.zeros((1500, 1500), dtype=bool), RESOLUTION))
    assert 1_000 < nodes < 20_000
    assert edges < 6 * nodes


def test_a_field_of_circles_is_prepared_too():
    planner = Planner(seed=2)
    first = planner.plan(paper.field(), paper.START, paper.GOALS)
    planner.prepare(paper.field())
    x, y = 0.5 * (first.path[0] + first.path[1])
    more = CircleField(3.0, 4.0, [*paper.field().obstacles.tolist(), (float(x), float(y), 0.1)])
    again = planner.plan(more, paper.START, paper.GOALS)
    for a, b in zip(again.path[:-1], again.path[1:], strict=True):
        assert more.segment_clear(tuple(a), tuple(b), 0.15)
