"""The simulated ultrasonic sensors: cone, reach, timing, noise and dropouts."""

from __future__ import annotations

import math

import numpy as np
import pytest
from rover_hil.testing.plants import make_plant
from rover_plant import Plant

LEFT, CENTRE, RIGHT = 0, 1, 2
HALF_ANGLE = math.radians(15.0)
# The centre sensor sits this far ahead of base_link.
CENTRE_X = 0.12

EXACT = {"dropout": 0.0, "noise": 0.0, "noise_fraction": 0.0, "sound_speed_tolerance": 0.0}


def with_obstacle(distance: float, bearing: float, radius: float = 0.1, height: float = 0.3, **config: float) -> Plant:
    """A plant with one disc, seen from the centre sensor at that distance and bearing."""
    x = 2.0 + CENTRE_X + distance * math.cos(bearing)
    y = 2.0 + distance * math.sin(bearing)
    return make_plant(obstacles=[[x, y, radius, height]], sonar={**EXACT, **config})


def centre_range(plant: Plant) -> float | None:
    return plant.sonar_range(CENTRE, 2.0, 2.0, 0.0)


def ping(plant: Plant, sensor: int, patience_ms: int = 40) -> tuple[int, int] | None:
    """Triggers and waits; (milliseconds until the answer, echo in µs)."""
    plant.trigger_sonar(sensor)
    for waited in range(1, patience_ms + 1):
        plant.step(0.0, 0.0, False)
        answer = plant.poll_echo()
        if answer is not None:
            assert answer[0] == sensor
            return waited, answer[1]
    return None


def test_straight_ahead_the_range_ends_at_the_surface() -> None:
    assert centre_range(with_obstacle(1.0, 0.0)) == pytest.approx(0.9)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_centre_inside_the_cone_is_measured_along_its_own_bearing(side: float) -> None:
    assert centre_range(with_obstacle(1.0, side * math.radians(14.0))) == pytest.approx(0.9)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_the_cone_ends_where_its_edge_no_longer_touches_the_disc(side: float) -> None:
    tangent = HALF_ANGLE + math.asin(0.1 / 1.0)
    seen = centre_range(with_obstacle(1.0, side * (tangent - 0.01)))
    assert seen is not None
    assert 0.9 < seen < 1.0
    assert centre_range(with_obstacle(1.0, side * (tangent + 0.01))) is None


def test_what_stands_beside_or_behind_is_not_heard() -> None:
    assert centre_range(with_obstacle(0.5, math.radians(90.0))) is None
    assert centre_range(with_obstacle(0.5, math.radians(180.0))) is None


def test_what_is_lower_than_the_sensor_is_not_heard() -> None:
    assert centre_range(with_obstacle(1.0, 0.0, height=0.09)) is None
    assert centre_range(with_obstacle(1.0, 0.0, height=0.11)) is not None


def test_range_ends_at_four_metres_and_begins_at_two_centimetres() -> None:
    far, near = with_obstacle(4.2, 0.0), with_obstacle(0.11, 0.0)
    assert centre_range(far) is None
    assert far.sonar_range(CENTRE, 2.2, 2.0, 0.0) == pytest.approx(3.9)
    assert centre_range(near) == pytest.approx(0.02)


def test_the_side_sensors_look_thirty_degrees_aside() -> None:
    plant = with_obstacle(1.0, math.radians(35.0))
    assert plant.sonar_range(LEFT, 2.0, 2.0, 0.0) is not None
    assert plant.sonar_range(RIGHT, 2.0, 2.0, 0.0) is None


def test_the_nearest_of_two_answers() -> None:
    plant = make_plant(obstacles=[[3.0, 2.0, 0.1, 0.3], [2.7, 2.05, 0.1, 0.3]], sonar=EXACT)
    assert centre_range(plant) == pytest.approx(math.hypot(2.7 - 2.12, 0.05) - 0.1)


def test_an_echo_comes_after_its_flight_time() -> None:
    answer = ping(with_obstacle(1.0, 0.0), CENTRE)
    assert answer is not None
    waited_ms, echo_us = answer
    assert echo_us == round(900.5 * 2e3 / 343.0)
    assert waited_ms == math.ceil((806 + 650 + echo_us) / 1000)


def test_without_an_obstacle_the_timer_gives_up() -> None:
    assert ping(make_plant(), LEFT) == (27, 0)


def test_a_second_trigger_while_waiting_is_ignored() -> None:
    plant = with_obstacle(1.0, 0.0)
    plant.trigger_sonar(CENTRE)
    answer = ping(plant, CENTRE)
    assert answer is not None
    assert ping(plant, LEFT, patience_ms=20) is None


def test_noise_and_dropouts_are_as_configured() -> None:
    plant = make_plant(obstacles=[[3.12, 2.0, 0.1, 0.3]], sonar={"sound_speed_tolerance": 0.0}, seed=5)
    echoes = np.array([answer[1] for answer in (ping(plant, CENTRE) for _ in range(1500)) if answer is not None])
    heard = echoes[echoes > 0] * 343.0 / 2e6
    assert len(echoes) == 1500
    assert 0.01 < np.mean(echoes == 0) < 0.03
    assert heard.mean() == pytest.approx(0.9, abs=0.001)
    assert heard.std() == pytest.approx(0.002 + 0.004 * 0.9, rel=0.1)
