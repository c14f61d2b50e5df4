"""Where to go next: repeatable, only to where the rover can come, and to goals as well as to unseen ground."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from rover.geometry import Pose2
from rover.mapping.survey_grid import SurveyGrid
from rover.mission.config import Area, Launch
from rover.mission.freespace import MARGIN, FreeSpace, free_space
from rover.mission.goals import Goal
from rover.mission.targets import (
    MAX_VIEWPOINTS,
    MIN_GAIN,
    VIEWPOINT_SPACING,
    Decision,
    Target,
    _way_out,
    candidates,
    decide,
    tour_planner,
)
from rover.vehicle import Vehicle
from rover.vision.camera.file import load_camera

RESOLUTION = 0.02
HERE = Pose2(0.6, 0.6, 0.0)
STANDOFF = 0.45
RADIUS = Vehicle().radius + MARGIN
FOOTPRINT = SurveyGrid(1.0, 1.0).view_polygon(load_camera("lepton-160"))
WALL = tuple((1.2, y, 0.1) for y in np.arange(0.0, 2.5, 0.1))


def ground(*obstacles: tuple[float, float, float], unseen: NDArray[np.bool_] | None = None) -> FreeSpace:
    """2.4 x 2.4 m with these obstacles."""
    seen = np.ones((120, 120), bool) if unseen is None else ~unseen
    area = Area(2.4, 2.4, obstacles)
    return free_space(np.zeros_like(seen), seen, RESOLUTION, (), area, Launch(HERE, 0.25), Vehicle())


def unseen_right() -> NDArray[np.bool_]:
    unseen = np.zeros((120, 120), bool)
    unseen[:, 80:] = True
    return unseen


NOTHING_UNSEEN = np.zeros((120, 120), bool)


def options(space: FreeSpace, goals: list[Goal], unseen: NDArray[np.bool_] = NOTHING_UNSEEN) -> list[Target]:
    return candidates(space, HERE, goals, unseen, FOOTPRINT, STANDOFF)


def test_a_goal_is_looked_at_from_its_standoff_and_faced() -> None:
    goal = Goal("place-1", 1.6, 1.6, 1)
    (target,) = options(ground(), [goal])
    assert target.goal is goal
    distance = math.hypot(goal.x - target.pose.x, goal.y - target.pose.y)
    assert STANDOFF - RESOLUTION <= distance <= STANDOFF + 0.4 + RESOLUTION
    bearing = math.atan2(goal.y - target.pose.y, goal.x - target.pose.x)
    assert math.remainder(bearing - target.pose.heading, 2 * math.pi) == pytest.approx(0.0, abs=0.02)


def test_another_attempt_looks_from_another_side() -> None:
    poses = [options(ground(), [Goal("place-1", 1.4, 1.4, 1, attempts=n)])[0].pose for n in range(3)]
    assert min(poses[0].distance(poses[1]), poses[1].distance(poses[2]), poses[0].distance(poses[2])) > 0.3


def test_unseen_ground_offers_views_that_lie_apart_and_show_enough() -> None:
    unseen = unseen_right()
    views = options(ground(unseen=unseen), [], unseen)
    assert 1 <= len(views) <= MAX_VIEWPOINTS
    assert all(view.goal is None and view.gain_m2 >= MIN_GAIN for view in views)
    gaps = [a.pose.distance(b.pose) for n, a in enumerate(views) for b in views[n + 1 :]]
    assert all(gap >= VIEWPOINT_SPACING for gap in gaps)


def test_with_nothing_left_to_see_or_inspect_there_is_nowhere_to_go() -> None:
    assert options(ground(), []) == []
    assert decide(ground(), HERE, [], tour_planner(RADIUS, 1)) is None


def test_what_lies_behind_a_wall_is_offered_to_nobody() -> None:
    assert options(ground(*WALL), [Goal("place-1", 2.0, 2.0, 1)]) == []


def test_targets_that_cannot_be_reached_give_no_decision() -> None:
    beyond = [Target(Pose2(2.0, y, 0.0), None, 0.1) for y in (0.6, 2.0)]
    assert decide(ground(*WALL), HERE, beyond, tour_planner(RADIUS, 1)) is None
    assert (
        decide(ground((2.0, 2.0, 0.3)), HERE, [Target(Pose2(2.0, 2.0, 0.0), None, 0.1)], tour_planner(RADIUS, 1))
        is None
    )


def test_the_reachable_target_is_taken_when_others_are_not() -> None:
    near, beyond = (Target(Pose2(x, 1.8, 0.0), None, 0.1) for x in (0.6, 2.0))
    decision = decide(ground(*WALL), HERE, [beyond, near], tour_planner(RADIUS, 1))
    assert decision is not None
    assert decision.target is near
    assert decision.tour == (near,)


def tour_around_a_rock(seed: int) -> tuple[FreeSpace, list[Target], Decision]:
    space = ground((1.2, 1.2, 0.25))
    targets = [Target(Pose2(x, y, 0.0), None, 0.1) for x, y in ((1.9, 1.9), (0.5, 1.9), (1.9, 0.5))]
    decision = decide(space, HERE, targets, tour_planner(RADIUS, seed))
    assert decision is not None
    return space, targets, decision


def test_the_stretch_leads_from_here_to_the_target_over_free_ground() -> None:
    space, targets, decision = tour_around_a_rock(3)
    assert sorted(map(id, decision.tour)) == sorted(map(id, targets))
    assert decision.target is decision.tour[0]
    np.testing.assert_allclose(decision.path[0], (HERE.x, HERE.y), atol=1e-9)
    np.testing.assert_allclose(decision.path[-1], (decision.target.pose.x, decision.target.pose.y), atol=1e-9)
    assert space.is_clear(decision.path)


def test_the_same_map_pose_and_seed_give_the_same_decision() -> None:
    first, second = (tour_around_a_rock(7)[2] for _ in range(2))
    np.testing.assert_array_equal(first.path, second.path)
    assert (first.iterations, first.nodes, first.length) == (second.iterations, second.nodes, second.length)
    assert [t.pose for t in first.tour] == [t.pose for t in second.tour]
    unseen = unseen_right()
    once, again = (options(ground(unseen=unseen), [Goal("place-1", 1.0, 1.6, 1)], unseen) for _ in range(2))
    assert [(t.pose, t.gain_m2) for t in once] == [(t.pose, t.gain_m2) for t in again]


def test_a_rover_that_stands_a_little_too_near_to_something_may_leave() -> None:
    space = ground((0.6, 0.6 - 0.1 - space_radius() + 0.03, 0.1))
    target = Target(Pose2(0.6, 1.8, 0.0), None, 0.1)
    decision = decide(space, HERE, [target], tour_planner(RADIUS, 1))
    assert decision is not None
    assert decision.path[-1].tolist() == pytest.approx([0.6, 1.8])


def space_radius() -> float:
    return ground().radius


def test_from_beside_an_obstacle_the_way_begins_on_the_ground_that_leads_somewhere() -> None:
    """The nearest free cell is a pocket of one cell; a little farther the whole field begins."""
    free = np.zeros((100, 100), bool)
    free[50, 52] = True
    free[:, 55:] = True
    here = Pose2(50.5 * RESOLUTION, 50.5 * RESOLUTION, 0.0)
    x, y = _way_out(free, here, RESOLUTION, (0.0, 0.0))
    assert (math.floor(y / RESOLUTION), math.floor(x / RESOLUTION)) == (50, 55)
    assert _way_out(free, Pose2(1.5, 1.0, 0.0), RESOLUTION, (0.0, 0.0)) == (1.5, 1.0)
    far = Pose2(30.5 * RESOLUTION, 50.5 * RESOLUTION, 0.0)
    assert _way_out(free, far, RESOLUTION, (0.0, 0.0)) == (far.x, far.y)


def test_a_mission_goes_on_from_the_tree_of_its_last_decision_and_stays_off_what_is_new() -> None:
    planner = tour_planner(RADIUS, 1)
    targets = [Target(Pose2(x, y, 0.0), None, 0.1) for x, y in ((2.0, 0.6), (2.0, 2.0), (0.6, 2.0))]
    assert decide(ground(), HERE, targets, planner) is not None
    for obstacle in ((1.3, 0.6, 0.15), (1.3, 1.3, 0.2), (2.0, 1.3, 0.15)):
        space = ground(obstacle)
        decision = decide(space, HERE, targets, planner)
        assert decision is not None
        assert planner.repair.kept > 0
        assert space.is_clear(decision.path)
        assert len(decision.tour) == 3


def test_the_planner_of_a_mission_copes_with_a_map_that_begins_elsewhere() -> None:
    """Near ground is looked at first, then all of it: rectangles of one map."""
    planner, whole = tour_planner(RADIUS, 1), ground(*WALL[6:])
    target = [Target(Pose2(0.9, 1.0, 0.0), None, 0.1)]
    for space in (whole.around(np.array([[0.6, 0.6]]), 1.0), whole, whole.around(np.array([[0.9, 0.9]]), 0.8)):
        decision = decide(space, HERE, target, planner)
        assert decision is not None
        assert space.is_clear(decision.path)
