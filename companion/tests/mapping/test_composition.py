"""The map of many submaps: the same as of one while they lie alike, and moved with them when they do not."""

from __future__ import annotations

import copy
import math

import numpy as np
import pytest
from rover.capture.frame import Frame
from rover.geometry import Pose2
from rover.mapping.survey_grid import SurveyGrid
from rover.vehicle import Vehicle

from companion.tests.mapping.test_survey_grid import CAMERA, frame, look, spot

SONAR = Vehicle().sonars[1]
HOME = Pose2(0.0, 0.0, 0.0)
LAYERS = ("seen", "occupied", "temperature", "owner")


def same(one: SurveyGrid, other: SurveyGrid, names: tuple[str, ...] = LAYERS) -> None:
    for name in names:
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name), err_msg=name)


def anew(grid: SurveyGrid) -> SurveyGrid:
    """The same map put together from its submaps as a whole."""
    made = copy.deepcopy(grid)
    made._compose([made.area])
    return made


def event(rng: np.random.Generator) -> tuple[Pose2, Frame | float]:
    """A frame with something warm in it or an echo, from anywhere in the area."""
    x, y = rng.uniform(0.2, 2.8, 2).tolist()
    pose = Pose2(x, y, float(rng.uniform(-math.pi, math.pi)))
    if rng.random() < 0.5:
        return pose, float(rng.uniform(0.2, 0.75))
    return pose, frame(float(rng.uniform(0.4, 0.9)), float(rng.uniform(-0.2, 0.2)), contrast=float(rng.choice((0, 8))))


def take(grid: SurveyGrid, pose: Pose2, what: Frame | float) -> None:
    if isinstance(what, Frame):
        grid.integrate_frame(what, CAMERA, pose, 0.01, [spot("obstacle", 0.6, 0.0)])
    else:
        grid.integrate_sonar(pose, SONAR, what)


@pytest.mark.parametrize("seed", range(4))
def test_while_all_submaps_lie_alike_the_map_is_that_of_a_single_one(seed: int) -> None:
    rng = np.random.default_rng(seed)
    single, many = SurveyGrid(3.0, 3.0), SurveyGrid(3.0, 3.0)
    for step in range(60):
        many.place([HOME] * (1 + step // 15), int(rng.integers(1 + step // 15)))
        what = event(rng)
        take(single, *what)
        take(many, *what)
    assert len(np.unique(many.owner)) > 2
    same(single, many, ("seen", "occupied", "temperature"))
    same(many, anew(many))


@pytest.mark.parametrize("seed", range(4))
def test_what_a_frame_or_a_move_changes_is_what_the_whole_map_put_together_anew_shows(seed: int) -> None:
    rng = np.random.default_rng([seed, 1])
    grid = SurveyGrid(3.0, 3.0)
    poses = [HOME]
    for step in range(60):
        if step % 20 == 19:
            poses.append(poses[int(rng.integers(len(poses)))])
        if step % 7 == 6:
            poses = [Pose2(*(rng.standard_normal(3) * (0.05, 0.05, 0.02)).tolist()) for _ in poses]
        grid.place(poses, int(rng.integers(len(poses))))
        take(grid, *event(rng))
        same(grid, anew(grid))


def test_what_was_seen_moves_with_its_submap_and_the_rest_stays() -> None:
    grid = SurveyGrid(3.0, 2.0)
    look(grid, spot("obstacle"))
    grid.place([HOME, HOME], 1)
    grid.integrate_frame(frame(contrast=0.0), CAMERA, Pose2(1.9, 1.0, 0.0), 0.01, [])
    before = copy.deepcopy(grid)
    cells = 5
    grid.place([HOME, Pose2(0.0, cells * grid.resolution, 0.0)], 1)
    own = before.owner == 1
    assert own.any()
    np.testing.assert_array_equal(np.roll(own, cells, axis=0), grid.owner == 1)
    assert grid.occupied[before.occupied & ~np.roll(own, cells, axis=0)].all()


def test_turned_submaps_leave_no_holes_in_what_they_have_seen() -> None:
    grid = SurveyGrid(3.0, 2.0)
    for x in (0.3, 0.6, 0.9, 1.2):
        grid.integrate_frame(frame(contrast=0.0), CAMERA, Pose2(x, 1.0, 0.0), 0.01, [])
    rows, columns = np.nonzero(grid.seen)
    inner = (slice(rows.min() + 12, rows.max() - 12), slice(columns.min() + 30, columns.max() - 25))
    assert grid.seen[inner].all()
    grid.place([Pose2(0.0, 0.0, 0.03)], 0)
    assert grid.seen[inner].all()


def test_an_obstacle_known_to_one_submap_is_freed_by_what_another_one_sees_later() -> None:
    grid = SurveyGrid(2.0, 2.0)
    look(grid, spot("obstacle"))
    assert grid.occupied.any()
    grid.place([HOME, HOME], 1)
    look(grid, times=12, picture=frame(contrast=0.0))
    assert not grid.occupied.any()


def test_changes_name_every_cell_that_has_changed() -> None:
    rng = np.random.default_rng(5)
    grid = SurveyGrid(3.0, 3.0)
    grid.place([HOME, HOME], 0)
    for step in range(40):
        before = copy.deepcopy(grid)
        if step % 10 == 9:
            grid.place([HOME, Pose2(*(rng.standard_normal(3) * (0.05, 0.05, 0.02)).tolist())], step % 2)
        take(grid, *event(rng))
        told = np.zeros(grid.shape, bool)
        for where in grid.changes():
            told[where.slices(grid.area)] = True
        for name in ("seen", "occupied"):
            assert told[getattr(grid, name) != getattr(before, name)].all()


def test_what_is_kept_comes_back() -> None:
    rng = np.random.default_rng(6)
    grid, poses = SurveyGrid(3.0, 3.0), [HOME, Pose2(0.03, -0.02, 0.01)]
    grid.place(poses, 0)
    for step in range(30):
        grid.place(poses, step % 2)
        take(grid, *event(rng))
    other = SurveyGrid(3.0, 3.0)
    other.restore(grid.layers(), poses)
    same(grid, other)
    with pytest.raises(ValueError, match="submap 2"):
        other.restore(grid.layers(), [*poses, HOME])
    with pytest.raises(ValueError, match="fit"):
        SurveyGrid(30.0, 3.0).restore({**grid.layers(), "0_seen": np.zeros((2, 2), bool)}, poses)


def test_submaps_that_sleep_make_the_same_map() -> None:
    """One of two maps never lets any of its submaps go."""
    rng, again = np.random.default_rng(7), np.random.default_rng(7)
    poses = [HOME, Pose2(0.03, -0.02, 0.01), Pose2(-0.01, 0.04, -0.02), Pose2(0.02, 0.02, 0.0)]
    sleeping, awake = SurveyGrid(14.0, 3.0), SurveyGrid(14.0, 3.0)
    slept = 0
    for step in range(60):
        active = (step // 4) % 4
        moved = [*poses[:3], Pose2(0.02 + 0.02 * (step // 20), 0.02, 0.0)]
        for grid, chance in ((sleeping, rng), (awake, again)):
            grid.place(moved, active)
            pose, what = event(chance)
            take(grid, Pose2(pose.x + 3.6 * active, pose.y, pose.heading), what)
        slept += sum(piece.asleep for piece in sleeping.pieces)
        for piece in awake.pieces:
            assert piece.grid is not None
        same(sleeping, awake)
    assert slept > 30


def test_what_a_run_of_before_has_kept_comes_back() -> None:
    """It kept every cell of a window, known or not."""
    rng = np.random.default_rng(8)
    grid = SurveyGrid(3.0, 3.0)
    for _ in range(10):
        take(grid, *event(rng))
    own = grid.pieces[0]
    whole = {"0_window": own.packed()["window"]} | {f"0_{name}": layer for name, layer in own.grid.layers().items()}
    other = SurveyGrid(3.0, 3.0)
    other.restore(whole, [HOME])
    same(grid, other)
    assert sum(layer.nbytes for layer in grid.layers().values()) < sum(layer.nbytes for layer in whole.values())


def test_known_cells_that_do_not_fit_are_refused() -> None:
    grid = SurveyGrid(3.0, 3.0)
    take(grid, *event(np.random.default_rng(9)))
    layers = grid.layers()
    with pytest.raises(ValueError, match="known cells"):
        SurveyGrid(3.0, 3.0).restore({**layers, "0_known": layers["0_known"][:-1]}, [HOME])
    with pytest.raises(ValueError, match="thermal"):
        SurveyGrid(3.0, 3.0).restore({**layers, "0_thermal": layers["0_thermal"][:-1]}, [HOME])


def test_where_much_has_moved_the_ground_around_the_rover_comes_first_and_the_rest_with_the_next_frames() -> None:
    rng = np.random.default_rng(10)
    grid = SurveyGrid(14.0, 14.0)
    poses = [HOME] * 9
    for number in range(9):
        grid.place(poses, number)
        for _ in range(4):
            pose, what = event(rng)
            take(grid, Pose2(pose.x + 4.5 * (number % 3), pose.y + 4.5 * (number // 3), pose.heading), what)
    grid.place([Pose2(0.05, 0.03, 0.0)] * 9, 0)
    whole = anew(grid)
    near = np.s_[:150, :150]
    np.testing.assert_array_equal(grid.seen[near], whole.seen[near])
    assert (grid.seen != whole.seen).any()
    for _ in range(40):
        take(grid, Pose2(1.0, 1.0, 0.0), frame(0.6, 0.0, contrast=0.0))
    same(grid, anew(grid))
    grid.place([Pose2(0.09, 0.0, 0.01)] * 9, 0)
    grid.settle()
    same(grid, anew(grid))
