"""Weak spots are kept off while there is another way, wherever no wheel has been yet."""

from __future__ import annotations

import numpy as np
import pytest
import rover.mission.caution as caution_module
from rover.geometry import Pose2
from rover.mapping.survey_grid import SurveyGrid
from rover.mission.caution import BOLD, CAUTIOUS, SPOT_RADIUS, Caution
from rover.mission.config import Area, Launch
from rover.mission.freespace import FreeSpace, free_space
from rover.vehicle import STANDARD

LAUNCH = Launch(Pose2(0.5, 0.5, 0.0), 0.25)
FAR = Pose2(0.5, 0.5, 0.0)
SPOT = (2.01, 1.51)


@pytest.fixture
def grid() -> SurveyGrid:
    """3 x 3 m, all seen, with a warm spot as above a mine 5 cm deep."""
    grid = SurveyGrid(3.0, 3.0)
    rng = np.random.default_rng(1)
    y, x = (np.mgrid[:150, :150] + 0.5) * grid.resolution
    warmth = 1.0 * 0.5 ** ((np.hypot(x - SPOT[0], y - SPOT[1]) / 0.06) ** 2)
    grid.temperature[:] = 290.0 + warmth + rng.normal(0.0, 0.2, warmth.shape)
    grid.seen[:] = True
    return grid


def ground(grid: SurveyGrid) -> FreeSpace:
    return free_space(grid.occupied, grid.seen, grid.resolution, (), Area(3.0, 3.0, ()), LAUNCH, STANDARD)


def is_open(space: FreeSpace, x: float, y: float) -> bool:
    return bool(space.free[int(y / space.resolution), int(x / space.resolution)])


def test_the_wheels_stay_off_a_weak_spot_and_nothing_else_is_forbidden(grid: SurveyGrid) -> None:
    caution = Caution(grid, 1)
    caution.look(FAR)
    careful = caution.keep_off(ground(grid), BOLD, FAR)
    away = STANDARD.wheel_reach + 0.055
    assert not is_open(careful, SPOT[0] - away, SPOT[1])
    assert is_open(careful, SPOT[0] - careful.radius - SPOT_RADIUS - 0.06, SPOT[1])
    assert not careful.occluders.any()


def test_a_spot_that_a_wheel_went_over_is_none_any_more(grid: SurveyGrid) -> None:
    caution = Caution(grid, 1)
    caution.look(FAR)
    caution.drive(Pose2(SPOT[0], SPOT[1] - 0.5 * STANDARD.track_width, 0.0), STANDARD)
    assert is_open(caution.keep_off(ground(grid), BOLD, FAR), *SPOT)


def test_a_spot_under_the_rover_does_not_lock_it_in(grid: SurveyGrid) -> None:
    caution = Caution(grid, 1)
    caution.look(FAR)
    assert is_open(caution.keep_off(ground(grid), CAUTIOUS, Pose2(SPOT[0] + 0.05, SPOT[1], 0.0)), *SPOT)


def test_what_is_warm_about_an_obstacle_is_no_weak_spot(grid: SurveyGrid) -> None:
    grid.temperature[70:82, 20:32] += 8.0
    grid.thermal[70:82, 20:32] = 2.0
    caution = Caution(grid, 1)
    caution.look(FAR)
    assert caution.likeness is not None
    assert caution.likeness[60:92, 10:42].max() < BOLD


def test_what_is_looked_at_piece_by_piece_is_what_one_look_at_all_says_there(grid: SurveyGrid) -> None:
    whole, piecewise = Caution(grid, 1), Caution(grid, 1)
    piecewise.look(FAR)
    grid.temperature[60:90, 90:110] += 0.5
    for x, y in ((0.5, 0.5), (2.5, 0.5), (2.5, 2.5), (1.9, 1.5)):
        piecewise.look(Pose2(x, y, 0.0))
    whole.look(FAR)
    assert whole.likeness is not None
    assert piecewise.likeness is not None
    np.testing.assert_allclose(piecewise.likeness[60:90, 90:110], whole.likeness[60:90, 90:110], rtol=0.25, atol=0.3)


def test_what_a_wheel_went_over_moves_with_its_ground(grid: SurveyGrid) -> None:
    """A loop is closed: spot and track are 20 cm farther now, and the spot is still none."""
    caution = Caution(grid, 1)
    grid.integrate_sonar(Pose2(1.0, 1.0, 0.0), STANDARD.sonars[0], None)
    caution.look(FAR)
    caution.drive(Pose2(SPOT[0], SPOT[1] - 0.5 * STANDARD.track_width, 0.0), STANDARD)
    warm = grid.temperature.copy()
    grid.place([Pose2(0.2, 0.0, 0.0)], 0)
    grid.temperature[:] = np.roll(warm, 10, axis=1)
    grid.seen[:] = True
    caution.look(FAR)
    assert is_open(caution.keep_off(ground(grid), BOLD, FAR), SPOT[0] + 0.2, SPOT[1])
    afresh = Caution(grid, 1)
    afresh.look(FAR)
    assert not is_open(afresh.keep_off(ground(grid), BOLD, FAR), SPOT[0] + 0.2, SPOT[1])


def test_a_large_map_is_looked_at_some_rows_with_each_frame(grid: SurveyGrid, monkeypatch: pytest.MonkeyPatch) -> None:
    """From a corner: nothing of it is in the window around the rover."""
    monkeypatch.setattr(caution_module, "STRIP_CELLS", 100)
    monkeypatch.setattr(caution_module, "WINDOW", 0.4)
    caution = Caution(grid, 1)
    looks = 0
    while looks < 10 and is_open(caution.keep_off(ground(grid), BOLD, FAR), *SPOT):
        caution.look(FAR)
        looks += 1
    assert 1 <= looks <= 4
