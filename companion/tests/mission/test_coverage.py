"""Which ground is still to be looked at."""

from __future__ import annotations

import numpy as np
import pytest
from rover.geometry import Pose2
from rover.mapping.survey_grid import SurveyGrid
from rover.mission.config import Area, Launch
from rover.mission.coverage import MAX_LOOKS, Coverage

LAUNCH = Launch(Pose2(0.5, 0.5, 0.0), 0.25)


def coverage(*obstacles: tuple[float, float, float]) -> tuple[SurveyGrid, Coverage]:
    grid = SurveyGrid(2.0, 2.0)
    return grid, Coverage(grid, Area(2.0, 2.0, obstacles), LAUNCH)


def area_m2(grid: SurveyGrid, mask: np.ndarray) -> float:
    return float(mask.sum()) * grid.resolution**2


def test_at_the_start_all_but_the_launch_and_the_known_obstacles_is_unseen() -> None:
    grid, ground = coverage((1.5, 1.5, 0.3))
    expected = 4.0 - np.pi * (0.25**2 + 0.3**2)
    assert area_m2(grid, ground.unseen()) == pytest.approx(expected, abs=0.02)


def test_ground_that_a_viewpoint_should_have_shown_is_hidden_after_a_few_looks() -> None:
    grid, ground = coverage()
    view = np.zeros(grid.shape, bool)
    view[60:80, 60:80] = True
    for _ in range(MAX_LOOKS):
        assert ground.unseen()[70, 70]
        ground.look(view)
    assert not ground.unseen()[70, 70]
    assert np.array_equal(ground.hidden(), view)


def test_hidden_ground_that_shows_after_all_is_neither_hidden_nor_unseen() -> None:
    grid, ground = coverage()
    for _ in range(MAX_LOOKS):
        ground.look(np.ones(grid.shape, bool))
    grid.seen[:] = True
    assert not ground.hidden().any()
    assert not ground.unseen().any()


def test_looks_of_another_area_do_not_fit() -> None:
    _, ground = coverage()
    with pytest.raises(ValueError, match="fit"):
        ground.restore(np.zeros((3, 3), np.uint8))
