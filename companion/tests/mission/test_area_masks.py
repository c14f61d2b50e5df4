"""Outlines: what lies in them, what they leave out, and the way in."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rover.errors import BadInput
from rover.mission.area_masks import entered, wanted
from rover.mission.config import Mission, from_document
from rover.mission.outline import STRIP_M, contains, inside

SQUARE = ((1.0, 1.0), (2.0, 1.0), (2.0, 2.0), (1.0, 2.0))
L_SHAPE = [[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]]


def a_mission(launch: tuple[float, float] = (0.5, 0.5), **area: Any) -> Mission:
    return from_document({"area": area, "launch": {"x_m": launch[0], "y_m": launch[1]}}, Path("field.toml"))


def size_m2(mask: np.ndarray, cell: float = 0.05) -> float:
    return float(mask.sum()) * cell**2


@pytest.mark.parametrize(
    ("point", "is_in"), [((1.5, 1.5), True), ((0.5, 1.5), False), ((2.5, 1.5), False), ((1.5, 2.5), False)]
)
def test_a_point_lies_in_an_outline_or_not(point: tuple[float, float], is_in: bool) -> None:
    assert inside(SQUARE, point) is is_in


def test_which_way_round_an_outline_goes_does_not_matter() -> None:
    x, y = np.meshgrid(np.linspace(0.0, 3.0, 31) + 0.01, np.linspace(0.0, 3.0, 31) + 0.01)
    assert np.array_equal(contains(SQUARE, x, y), contains(SQUARE[::-1], x, y))


def test_the_map_of_a_polygon_reaches_over_it() -> None:
    area = a_mission(polygon=L_SHAPE).area
    assert (area.width, area.height) == (3.0, 3.0)
    assert size_m2(wanted(area, (60, 60), 0.05)) == pytest.approx(5.0)


def test_what_is_excluded_is_neither_surveyed_nor_entered() -> None:
    mission = a_mission(polygon=L_SHAPE, exclude=[[[2.0, 0.0], [3.0, 0.0], [3.0, 1.0], [2.0, 1.0]]])
    assert size_m2(wanted(mission.area, (60, 60), 0.05)) == pytest.approx(4.0)
    assert np.array_equal(entered(mission.area, mission.launch, (60, 60), 0.05), wanted(mission.area, (60, 60), 0.05))


def test_a_rectangle_may_have_exclusions_too() -> None:
    area = a_mission(width_m=2.0, height_m=2.0, exclude=[[[1.0, 1.0], [2.0, 1.0], [2.0, 2.0], [1.0, 2.0]]]).area
    assert size_m2(wanted(area, (40, 40), 0.05)) == pytest.approx(3.0)


def test_from_a_launch_outside_a_strip_leads_straight_in() -> None:
    mission = a_mission((0.5, 2.0), polygon=[[2.0, 0.0], [4.0, 0.0], [4.0, 3.0], [2.0, 3.0]])
    strip = entered(mission.area, mission.launch, (60, 80), 0.05) & ~wanted(mission.area, (60, 80), 0.05)
    rows, columns = np.nonzero(strip)
    assert strip[40, 20]
    assert (rows.max() + 1) * 0.05 <= 2.0 + STRIP_M + 0.05
    assert rows.min() * 0.05 >= 2.0 - STRIP_M - 0.05
    assert columns.min() == 0


def test_the_map_reaches_over_a_launch_outside() -> None:
    area = a_mission((3.0, 0.5), polygon=[[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]).area
    assert area.width == pytest.approx(3.0 + STRIP_M)


@pytest.mark.parametrize(
    ("area", "line"),
    [
        ({"polygon": [[0, 0], [1, 0]]}, "at least 3 different points"),
        ({"polygon": [[0, 0], [1, 0], [2, 0]]}, "must enclose"),
        ({"polygon": [[0, 0], [1, 0], [1, -1]]}, "[area] polygon point 3: -1 lies outside 0 to 100"),
        ({"polygon": [[0, 0], [1, 0], [1, "x"]]}, "[area] polygon point 3"),
        ({"polygon": 3}, "must be a list of points [x, y], not 3"),
        ({"polygon": L_SHAPE, "width_m": 3.0}, "[area] width_m: has no meaning beside polygon"),
        ({"width_m": 2.0, "height_m": 2.0, "exclude": [[1, 2]]}, "[area] exclude entry 1"),
        (
            {"width_m": 2.0, "height_m": 2.0, "exclude": [[[0, 0], [1, 0], [1, 1], [0, 1]]]},
            "[launch] x_m, y_m: (0.5, 0.5) lies in an excluded part",
        ),
    ],
)
def test_an_outline_that_is_none_is_refused_by_name(area: dict[str, Any], line: str) -> None:
    with pytest.raises(BadInput) as refused:
        a_mission(**area)
    assert line in str(refused.value)


def test_a_goal_outside_of_the_polygon_is_refused() -> None:
    document = {
        "area": {"polygon": L_SHAPE},
        "launch": {"x_m": 0.5, "y_m": 0.5},
        "mission": {"goals": [[2.0, 2.0]]},
    }
    with pytest.raises(BadInput, match="outside the area's polygon"):
        from_document(document, Path("field.toml"))
