"""Free space that is kept from frame to frame is the one that the whole map gives, cell by cell."""

from __future__ import annotations

import numpy as np
import pytest
from rover.geometry import Pose2
from rover.mapping.rectangle import Rectangle
from rover.mapping.survey_grid import SurveyGrid
from rover.mission.config import Area, Launch
from rover.mission.freespace import MARGIN, FreeSpace, free_space
from rover.mission.keepout import Zone
from rover.mission.kept_space import KeptSpace
from rover.vehicle import STANDARD

LAUNCH = Launch(Pose2(0.5, 0.5, 0.0), 0.25)
SIDE = 4.0


def same(one: FreeSpace, other: FreeSpace) -> None:
    for name in ("blocked", "free", "occluders"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name), err_msg=name)


def some_rectangle(rng: np.random.Generator, grid: SurveyGrid) -> Rectangle:
    top, left = rng.integers(-10, grid.shape[0] - 5, 2).tolist()
    return Rectangle(top, left, top + int(rng.integers(1, 60)), left + int(rng.integers(1, 60))).within(grid.area)


@pytest.mark.parametrize("seed", range(6))
def test_whatever_changes_it_is_what_the_whole_map_gives(seed: int) -> None:
    rng = np.random.default_rng(seed)
    grid, area, zones = SurveyGrid(SIDE, SIDE), Area(SIDE, SIDE, ((2.0, 2.0, 0.1),)), dict[int, Zone]()
    kept = KeptSpace(grid, LAUNCH, STANDARD)
    for step in range(80):
        for _ in range(int(rng.integers(0, 4))):
            where = some_rectangle(rng, grid)
            if where.empty:
                continue
            layer = grid.seen if rng.random() < 0.7 else grid.occupied
            layer[where.slices(grid.area)] = rng.random() < 0.7
            grid.changed(where)
        number, (x, y) = int(rng.integers(5)), rng.uniform(0.0, SIDE, 2).tolist()
        if rng.random() < 0.5:
            zones[number] = Zone(number, x, y, float(rng.uniform(0.06, 0.3)), float(step))
        else:
            zones.pop(number, None)
        if step == 40:
            area = Area(SIDE, SIDE, (*area.obstacles, (3.0, 1.0, 0.2)))
        whole = free_space(grid.occupied, grid.seen, grid.resolution, zones.values(), area, LAUNCH, STANDARD)
        same(kept.now(zones.values(), area), whole)


def test_a_rectangle_around_a_path_judges_it_as_the_whole_map_does() -> None:
    rng = np.random.default_rng(9)
    grid = SurveyGrid(SIDE, SIDE)
    grid.seen[:] = True
    for _ in range(25):
        row, column = rng.integers(0, 195, 2).tolist()
        grid.occupied[row : row + 5, column : column + 5] = True
    space = free_space(grid.occupied, grid.seen, grid.resolution, (), Area(SIDE, SIDE, ()), LAUNCH, STANDARD)
    clear = 0
    for _ in range(300):
        path = rng.uniform(0.0, SIDE, (2, 2))
        path[1] = path[0] + (path[1] - path[0]) * 0.2
        near = space.around(path)
        assert near.blocked.size < space.blocked.size
        assert near.is_clear(path) == space.is_clear(path)
        clear += space.is_clear(path)
    assert 30 < clear < 270


def test_who_does_not_know_well_where_the_border_is_stays_away_from_it_and_not_from_the_ground_inside() -> None:
    grid, area = SurveyGrid(SIDE, SIDE), Area(SIDE, SIDE, ())
    grid.seen[:] = True
    kept = KeptSpace(grid, LAUNCH, STANDARD)
    sure = kept.now((), area, 0.005).free.copy()
    vague = kept.now((), area, 0.08).free.copy()
    assert not (vague & ~sure).any()
    gap = (np.argmax(vague.any(axis=0)) - np.argmax(sure.any(axis=0))) * grid.resolution
    assert gap == pytest.approx(2.0 * 0.08 - MARGIN, abs=grid.resolution)
    np.testing.assert_array_equal(vague[40:-40, 40:-40], sure[40:-40, 40:-40])
    np.testing.assert_array_equal(kept.now((), area, 0.005).free, sure)
