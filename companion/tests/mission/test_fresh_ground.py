"""Ground under the wheels is counted once, however often they come there."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from rover.mission.fresh_ground import CELL_M, TYRE_M, fresh_wheel_area
from rover.vehicle import STANDARD


def straight(metres: float, heading: float = 0.0, x: float = 0.0) -> NDArray[np.float64]:
    way = np.arange(0.0, metres, 0.002)
    return np.column_stack((x + way * math.cos(heading), way * math.sin(heading), np.full(len(way), heading)))


def test_two_tyres_press_two_strips() -> None:
    assert fresh_wheel_area(straight(3.0), STANDARD) == pytest.approx(2.0 * 3.0 * TYRE_M, rel=0.02)


def test_there_and_back_in_the_same_tracks_is_no_more_than_there() -> None:
    there = straight(3.0)
    back = there[::-1] + np.array([0.0, 0.0, math.pi])
    both = fresh_wheel_area(np.vstack((there, back)), STANDARD)
    assert both == pytest.approx(fresh_wheel_area(there, STANDARD), rel=0.02)


def test_turning_on_the_spot_presses_one_ring() -> None:
    turn = np.column_stack((np.zeros(4000), np.zeros(4000), np.linspace(0.0, 4.0 * math.pi, 4000)))
    ring = math.pi * STANDARD.track_width * TYRE_M
    assert fresh_wheel_area(turn, STANDARD) == pytest.approx(ring, rel=0.35)


def test_negative_coordinates_and_long_ways_count_the_same() -> None:
    assert fresh_wheel_area(straight(20.0, x=-10.0), STANDARD) == pytest.approx(2.0 * 20.0 * TYRE_M, rel=0.01)
    assert fresh_wheel_area(straight(0.002), STANDARD) <= 2.0 * 4.0 * CELL_M**2


def test_a_rover_that_never_knew_where_it_was_has_pressed_nothing() -> None:
    assert fresh_wheel_area(np.zeros((0, 3)), STANDARD) == 0.0
    assert fresh_wheel_area(np.zeros((1, 3)), STANDARD) > 0.0
