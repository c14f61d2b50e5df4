"""Forbidden ground: each kind blocks as documented, and no free cell is nearer to it than the rover is wide."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from rover.geometry import Pose2
from rover.mission.config import Area, Launch
from rover.mission.freespace import CHECK_TOLERANCE, MARGIN, FreeSpace, disc_mask, free_space
from rover.mission.keepout import MINE_RADIUS_M, Zone
from rover.vehicle import STANDARD, Vehicle

RESOLUTION = 0.02
RADIUS = 0.15
LAUNCH = Launch(Pose2(0.5, 0.5, 0.0), 0.25)
SHAPE = (100, 100)


def space(
    *,
    occupied: NDArray[np.bool_] | None = None,
    seen: NDArray[np.bool_] | None = None,
    zones: tuple[Zone, ...] = (),
    obstacles: tuple[tuple[float, float, float], ...] = (),
    radius: float = RADIUS,
) -> FreeSpace:
    """A 2 x 2 m area, all seen and empty unless told otherwise."""
    return free_space(
        np.zeros(SHAPE, bool) if occupied is None else occupied,
        np.ones(SHAPE, bool) if seen is None else seen,
        RESOLUTION,
        zones,
        Area(2.0, 2.0, obstacles),
        LAUNCH,
        Vehicle(radius=radius),
    )


def at(mask: NDArray[np.bool_], x: float, y: float) -> bool:
    """The cell that holds a point."""
    return bool(mask[math.floor(y / RESOLUTION), math.floor(x / RESOLUTION)])


def way(*points: tuple[float, float]) -> NDArray[np.float64]:
    return np.array(points)


def test_seen_and_empty_ground_is_free_up_to_the_rovers_radius_and_margin_from_the_wall() -> None:
    ground = space()
    assert not ground.blocked.any()
    assert at(ground.free, 1.0, 1.0)
    border = RADIUS + MARGIN
    assert at(ground.free, border + 0.5 * RESOLUTION + 0.01, 1.0)
    assert not at(ground.free, border - 0.015, 1.0)
    assert not at(ground.free, 1.0, 2.0 - border + 0.015)


def test_unseen_ground_is_blocked_but_hides_nothing() -> None:
    seen = np.ones(SHAPE, bool)
    seen[:, 70:] = False
    ground = space(seen=seen)
    assert at(ground.blocked, 1.5, 1.0)
    assert not at(ground.free, 1.3, 1.0)
    assert at(ground.free, 1.0, 1.0)
    assert not ground.occluders.any()


def test_the_ground_that_the_operator_surveyed_at_the_launch_counts_as_shown() -> None:
    ground = space(seen=np.zeros(SHAPE, bool))
    np.testing.assert_array_equal(~ground.blocked, disc_mask(SHAPE, RESOLUTION, 0.5, 0.5, 0.25))
    assert at(ground.free, 0.5, 0.5)


def test_an_obstacle_on_the_launch_disc_blocks_all_the_same() -> None:
    occupied = disc_mask(SHAPE, RESOLUTION, 0.65, 0.5, 0.05)
    ground = space(occupied=occupied, seen=np.zeros(SHAPE, bool))
    assert at(ground.blocked, 0.65, 0.5)
    assert not at(ground.free, 0.5, 0.5)


def test_obstacles_found_and_given_block_and_hide() -> None:
    ground = space(occupied=disc_mask(SHAPE, RESOLUTION, 1.5, 1.5, 0.1), obstacles=((1.5, 0.5, 0.1),))
    for x, y in ((1.5, 1.5), (1.5, 0.5)):
        assert at(ground.blocked, x, y)
        assert at(ground.occluders, x, y)
        assert not at(ground.free, x - 0.1 - RADIUS, y)
        assert at(ground.free, x - 0.1 - RADIUS - MARGIN - 2 * RESOLUTION, y)


@pytest.mark.parametrize("radius", [0.08, 0.15, 0.4])
def test_a_zone_keeps_wheels_out_and_the_hull_off_the_mine_but_hides_nothing(radius: float) -> None:
    ground = space(zones=(Zone(1, 1.2, 1.2, radius, 0.0),))
    assert not ground.occluders.any()
    rows, columns = np.nonzero(ground.free)
    nearest = np.hypot((columns + 0.5) * RESOLUTION - 1.2, (rows + 0.5) * RESOLUTION - 1.2).min()
    assert nearest >= radius + STANDARD.wheel_reach
    assert nearest >= MINE_RADIUS_M + RADIUS


def test_the_map_that_is_handed_in_is_not_written_to() -> None:
    occupied, seen = np.zeros(SHAPE, bool), np.ones(SHAPE, bool)
    space(occupied=occupied, seen=seen, zones=(Zone(1, 1.0, 1.0, 0.15, 0.0),), obstacles=((1.5, 0.5, 0.1),))
    assert not occupied.any()
    assert seen.all()


def test_a_path_is_clear_until_something_comes_nearer_than_the_tolerance_allows() -> None:
    path = way((0.4, 1.0), (1.6, 1.0))
    reach = RADIUS + MARGIN - CHECK_TOLERANCE
    assert space(obstacles=((1.0, 1.0 + 0.1 + reach + RESOLUTION, 0.1),)).is_clear(path)
    assert not space(obstacles=((1.0, 1.0 + 0.1 + reach - RESOLUTION, 0.1),)).is_clear(path)
    assert not space().is_clear(way((0.4, 1.0), (1.95, 1.0)))
    assert CHECK_TOLERANCE <= MARGIN


def test_a_zone_drawn_beside_a_path_that_is_driven_leaves_a_wheel_room_for_the_worst_of_localization() -> None:
    path = way((0.4, 1.0), (1.6, 1.0))
    for offset in np.arange(0.0, 0.5, 0.005):
        if space(zones=(Zone(1, 1.0, 1.0 + offset, 0.15, 0.0),)).is_clear(path):
            assert offset >= 0.15 + STANDARD.wheel_reach + 0.016
            break
    else:
        raise AssertionError("the path is never clear")


def test_every_leg_of_a_path_is_checked() -> None:
    ground = space(obstacles=((1.5, 1.5, 0.1),))
    assert not ground.is_clear(way((0.4, 0.4), (1.5, 0.4), (1.5, 1.6)))
    assert not ground.is_clear(way((0.4, 0.4), (1.5, 1.5), (1.6, 0.4)))


def test_a_disc_holds_the_cells_whose_centre_lies_in_it() -> None:
    mask = disc_mask((4, 6), 0.1, 0.25, 0.15, 0.101)
    assert sorted(zip(*np.nonzero(mask), strict=True)) == [(0, 2), (1, 1), (1, 2), (1, 3), (2, 2)]


def gaps(blocked: NDArray[np.bool_], resolution: float) -> NDArray[np.float64]:
    """Distance of every cell's centre to the nearest blocked cell's square and to the border, one by one."""
    rows, columns = blocked.shape
    y, x = np.mgrid[:rows, :columns] + 0.5
    nearest = np.minimum.reduce([x, y, columns - x, rows - y])
    for row, column in zip(*np.nonzero(blocked), strict=True):
        aside = np.maximum(np.abs(x - column - 0.5) - 0.5, 0.0)
        along = np.maximum(np.abs(y - row - 0.5) - 0.5, 0.0)
        nearest = np.minimum(nearest, np.hypot(aside, along))
    metres: NDArray[np.float64] = nearest * resolution
    return metres


@settings(max_examples=40, deadline=None)
@given(
    st.lists(st.tuples(st.integers(0, 39), st.integers(0, 39)), min_size=0, max_size=12),
    st.floats(0.05, 0.2),
)
def test_no_free_cell_is_nearer_than_radius_and_margin_to_anything_blocked(
    cells: list[tuple[int, int]], radius: float
) -> None:
    occupied = np.zeros((40, 40), bool)
    for row, column in cells:
        occupied[row, column] = True
    area, launch = Area(0.8, 0.8, ()), Launch(Pose2(0.4, 0.4, 0.0), 0.2)
    ground = free_space(occupied, np.ones_like(occupied), RESOLUTION, (), area, launch, Vehicle(radius=radius))
    gap = gaps(ground.blocked, RESOLUTION)
    assert (gap[ground.free] >= ground.radius - 1e-9).all()
    # Nor is more ground given up than a cell's rounding costs.
    assert ground.free[gap >= ground.radius + 0.5 * RESOLUTION].all()


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_the_planner_agrees_that_the_rover_can_stand_on_every_free_cell(seed: int) -> None:
    rng = np.random.default_rng(seed)
    occupied = np.zeros(SHAPE, bool)
    for x, y in rng.uniform(0.0, 2.0, (8, 2)):
        occupied |= disc_mask(SHAPE, RESOLUTION, x, y, 0.08)
    ground = space(occupied=occupied)
    rows, columns = np.nonzero(ground.free)
    centres = (np.column_stack([columns, rows]) + 0.5) * RESOLUTION
    assert (ground.field().clearance(centres) >= ground.radius - 1e-9).all()
