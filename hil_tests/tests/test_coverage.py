"""What of the ground could be seen, and how much of it was, by the truth alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from rover.mission.config import Mission, from_document
from rover_hil.coverage import CELL, visible_ground

SHAPE = (150, 150)


def a_mission(**area: Any) -> Mission:
    document = {
        "area": area or {"width_m": 3.0, "height_m": 3.0},
        "launch": {"x_m": 0.5, "y_m": 0.5},
    }
    return from_document(document, Path("field.toml"))


def disc(x: float, y: float, radius: float) -> np.ndarray:
    rows, columns = np.indices(SHAPE)
    return np.asarray(np.hypot((columns + 0.5) * CELL - x, (rows + 0.5) * CELL - y) <= radius)


def at(mask: np.ndarray, x: float, y: float) -> bool:
    return bool(mask[int(y / CELL), int(x / CELL)])


NOTHING = np.zeros(SHAPE, bool)


def test_of_an_empty_field_everything_can_be_seen() -> None:
    assert visible_ground(a_mission(), SHAPE, NOTHING, []).all()


def test_ground_under_an_obstacle_is_none_to_be_seen() -> None:
    rock = disc(1.5, 1.5, 0.2)
    assert np.array_equal(visible_ground(a_mission(), SHAPE, rock, []), ~rock)


def test_a_mine_is_looked_at_from_outside_its_zone() -> None:
    assert visible_ground(a_mission(), SHAPE, NOTHING, [(1.5, 1.5)]).all()


def test_ground_behind_a_row_of_mines_is_only_seen_as_far_as_the_camera_reaches() -> None:
    row = [(0.1 + 0.2 * n, 1.2) for n in range(15)]
    visible = visible_ground(a_mission(), SHAPE, NOTHING, row)
    assert at(visible, 1.5, 0.3)
    assert at(visible, 1.5, 1.6)
    assert not at(visible, 1.5, 2.2)


def test_a_wall_hides_what_lies_behind_it() -> None:
    wall = np.zeros(SHAPE, bool)
    wall[60:64] = True
    visible = visible_ground(a_mission(), SHAPE, wall, [])
    assert at(visible, 1.5, 1.0)
    assert not visible[64:].any()


def test_only_the_area_counts_and_a_launch_outside_leads_in() -> None:
    corner = [[1.2, 1.2], [2.8, 1.2], [2.8, 2.8], [1.2, 2.8]]
    mission = a_mission(polygon=corner, exclude=[[[2.2, 2.2], [2.8, 2.2], [2.8, 2.8], [2.2, 2.8]]])
    visible = visible_ground(mission, (140, 140), np.zeros((140, 140), bool), [])
    assert not at(visible, 0.6, 0.6)
    assert at(visible, 1.3, 1.3)
    assert at(visible, 1.3, 2.7)
    assert not at(visible, 2.5, 2.5)


def test_a_launch_shut_in_by_rocks_leaves_little_to_be_seen() -> None:
    ring = disc(0.5, 0.5, 0.45) & ~disc(0.5, 0.5, 0.35)
    visible = visible_ground(a_mission(), SHAPE, ring, [])
    assert 0.0 < visible.mean() < 0.1
