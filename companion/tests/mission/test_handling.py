"""What the inertial sensor finds: slip, slopes, hands, a rover on its side; and what the mission does then."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest
from rover.link.telemetry import Gravity, Turned, WheelMotion
from rover.mission.fault_table import CHECKS, Check, Driving
from rover.mission.handling import Handling
from rover.mission.phase import Phase
from rover.vehicle import STANDARD

from companion.tests.mission.imagined_rover import ImaginedRover
from companion.tests.mission.test_fault_table import drives_within, driving

G = 9.80665
Motion = Callable[[float], tuple[float, float]]


def leaning(time: float, roll: float = 0.0, pitch: float = 0.0) -> Gravity:
    x, y, z = -math.sin(pitch), math.sin(roll) * math.cos(pitch), math.cos(roll) * math.cos(pitch)
    return Gravity(time, G * x, G * y, G * z, shake=0.0, status="Good")


def found(
    seconds: float,
    wheels: Motion = lambda t: (0.0, 0.0),
    turned: Callable[[float], float] = lambda t: 0.0,
    lean: Motion = lambda t: (0.0, 0.0),
) -> set[Check]:
    """All that is found within so many seconds. wheels: ways of both, metres; lean: roll, pitch."""
    handling, every = Handling(STANDARD), set[Check]()
    for step in range(round(seconds * 50)):
        time = 0.02 * step
        left, right = (round(way / STANDARD.metres_per_count) for way in wheels(time))
        handling.take(Turned(time, turned(time), 0.0))
        handling.take(WheelMotion(time, left, right))
        handling.take(leaning(time, *lean(time)))
        every |= handling.active
    return every


def test_a_drive_over_uneven_ground_with_curves_and_little_slip_finds_nothing() -> None:
    """3 % of slip of one wheel, 1.2 rad/s, 2° rms of ground with waves of a metre at 0.25 m/s."""
    assert not found(
        20.0,
        wheels=lambda t: (0.25 * t - 0.12 * math.sin(t), (0.25 * t + 0.12 * math.sin(t)) * 1.03),
        turned=lambda t: 1.2 * math.sin(t) + 0.0,
        lean=lambda t: (0.035 * math.sin(1.6 * t), 0.035 * math.cos(1.4 * t)),
    )


def test_a_wheel_that_spins_is_slip() -> None:
    assert found(3.0, wheels=lambda t: (0.2 * t, 0.35 * t), turned=lambda t: 0.0) == {Check.SLIPPING}


def test_a_slope_beyond_the_vehicles_limit_is_found_and_a_bump_is_none() -> None:
    steep = STANDARD.max_slope + math.radians(1.0)
    assert found(3.0, lean=lambda t: (0.0, -min(steep, 0.1 * t))) == {Check.STEEP}
    assert not found(3.0, lean=lambda t: (min(STANDARD.max_slope - math.radians(1.0), 0.1 * t), 0.0))


def test_a_rover_that_falls_over_is_found_lying() -> None:
    assert Check.TIPPED in found(4.0, lean=lambda t: (min(1.5, t), 0.0))


def test_hands_sway_what_they_hold_and_turn_what_stands() -> None:
    held = found(2.0, lean=lambda t: (0.05 * math.sin(8.2 * t), 0.05 * math.sin(8.2 * t + 1.0)))
    assert held == {Check.HANDLED}
    assert Check.HANDLED in found(2.0, turned=lambda t: 0.3 * t)


def test_without_a_sensor_nothing_is_ever_found() -> None:
    handling = Handling(STANDARD)
    for step in range(500):
        handling.take(WheelMotion(0.02 * step, 100 * step, 300 * step))
    assert not handling.active


def told(rover: ImaginedRover, seconds: float, lean: Motion) -> None:
    end = rover.now + seconds
    while rover.now < end and not rover.has_ended():
        rover.said = [leaning(rover.now, *lean(rover.now))]
        rover.step()


@pytest.mark.parametrize(
    ("check", "lean"), [(Check.STEEP, (0.0, -0.4)), (Check.TIPPED, (1.4, 0.0))], ids=["Steep", "Tipped"]
)
def test_steep_ground_and_a_fall_end_the_mission_at_rest(check: Check, lean: tuple[float, float]) -> None:
    assert CHECKS[check].driving is Driving.END
    rover = driving()
    told(rover, 1.0, lambda _: (0.0, 0.0))
    told(rover, 5.0, lambda _: lean)
    assert rover.outcome is not None
    assert rover.outcome.status is CHECKS[check].status
    assert rover.survey.drive.at_rest(rover.now)


def test_a_rover_in_somebodys_hands_waits_until_it_is_set_down() -> None:
    assert CHECKS[Check.HANDLED].driving is Driving.WAIT
    rover = driving()
    told(rover, 3.0, lambda t: (0.06 * math.sin(8.2 * t), 0.06 * math.sin(8.2 * t + 1.0)))
    assert rover.phase is Phase.PAUSED
    assert CHECKS[Check.HANDLED].line in rover.survey.holds.line
    told(rover, 3.0, lambda _: (0.02, 0.0))
    assert not rover.survey.holds
    assert drives_within(rover, 20.0)
