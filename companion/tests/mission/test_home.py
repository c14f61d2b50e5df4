"""Where the rover stands in the end: at its launch, or where it stopped, and which of them is told."""

from __future__ import annotations

import numpy as np
import pytest
from rover.geometry import Pose2
from rover.link.words import MotorState, StopCause
from rover.mission.config import Area, Launch
from rover.mission.freespace import free_space
from rover.mission.home import MAX_WAYS, WayHome
from rover.mission.phase import Phase
from rover.outcome import Outcome, RunStatus
from rover.vehicle import STANDARD

from companion.tests.mission.imagined_rover import Imagined, ImaginedRover, a_mission


def away_from_home(**world: object) -> ImaginedRover:
    """A rover in the middle of its survey, some way from the launch."""
    rover = ImaginedRover(a_mission(3.0, 3.0))
    while rover.perception.pose.distance(rover.mission.launch.pose) < 1.0:
        assert rover.survey.outcome is None
        rover.step()
    rover.become(**world)
    return rover


def distance_home(rover: ImaginedRover) -> float:
    return rover.perception.pose.distance(rover.mission.launch.pose)


def test_a_mission_that_is_done_ends_at_the_launch() -> None:
    rover = ImaginedRover(a_mission(3.0, 3.0)).run(600.0)
    assert rover.survey.outcome is not None
    assert rover.survey.outcome.status is RunStatus.DONE
    assert rover.survey.conclusion.home is not None
    assert rover.survey.conclusion.home.reached
    assert distance_home(rover) < 0.2


def test_a_mission_that_is_not_to_return_stays_and_says_so() -> None:
    rover = ImaginedRover(a_mission(3.0, 3.0, mission={"return_home": False})).run(600.0)
    assert rover.survey.outcome is not None
    assert rover.survey.outcome.status is RunStatus.DONE
    assert rover.survey.conclusion.home is not None
    assert not rover.survey.conclusion.home.reached
    assert "return_home" in rover.survey.conclusion.home.reason
    assert distance_home(rover) > 0.5


def test_a_battery_that_is_needed_for_the_way_back_ends_the_survey_above_the_firmwares_limit() -> None:
    rover = away_from_home(volts=6.25).run(300.0)
    assert rover.survey.outcome is not None
    assert rover.survey.outcome.status is RunStatus.PARTIAL
    assert "battery is needed for the way back" in rover.survey.outcome.reason
    assert rover.survey.conclusion.home is not None
    assert rover.survey.conclusion.home.reached
    assert distance_home(rover) < 0.2


def test_a_full_battery_ends_nothing() -> None:
    rover = away_from_home(volts=7.2).run(20.0)
    assert rover.survey.outcome is None
    assert rover.survey.conclusion.end is None


def test_a_motor_that_starts_does_not_make_an_empty_battery() -> None:
    rover = away_from_home()
    rover.run(6.0)
    rover.become(volts=6.3)
    rover.run(1.5)
    rover.become(volts=7.6)
    rover.run(6.0)
    assert rover.survey.conclusion.end is None


def test_the_time_limit_includes_the_way_back() -> None:
    rover = ImaginedRover(a_mission(4.0, 4.0, mission={"max_duration_s": 100.0})).run(300.0)
    assert rover.survey.outcome is not None
    assert rover.survey.outcome.status is RunStatus.PARTIAL
    assert rover.survey.conclusion.home is not None
    assert rover.survey.conclusion.home.reached
    assert rover.now < 110.0


def test_a_way_back_that_is_blocked_is_given_up_and_told() -> None:
    rover = away_from_home()
    there = rover.perception.pose
    rows, columns = (int(value / rover.perception.grid.resolution) for value in (there.y, there.x))
    wall = rover.perception.grid.occupied
    wall[max(rows - 25, 0) : rows + 26, max(columns - 25, 0) : columns + 26] = True
    wall[rows - 22 : rows + 23, columns - 22 : columns + 23] = False
    rover.survey.abort(Outcome(RunStatus.PARTIAL, "enough"), home=True)
    rover.run(200.0)
    assert rover.survey.outcome == Outcome(RunStatus.PARTIAL, "enough")
    assert rover.survey.conclusion.home is not None
    assert not rover.survey.conclusion.home.reached
    assert "way back" in rover.survey.conclusion.home.reason


@pytest.mark.parametrize(
    ("world", "why"),
    [
        ({"frames": False}, "camera"),
        ({"sigma": 5.0}, "does not know where it is"),
        ({"state": MotorState.LATCHED, "cause": StopCause.LOW_BATTERY}, "LowBattery"),
        ({"state": MotorState.LATCHED, "cause": StopCause.EMERGENCY_INPUT}, "EmergencyInput"),
    ],
)
def test_a_rover_that_must_not_drive_stays_where_it_is_and_says_why(world: dict[str, object], why: str) -> None:
    rover = away_from_home(**world).run(200.0)
    assert rover.survey.conclusion.home is not None
    assert not rover.survey.conclusion.home.reached
    assert why in rover.survey.conclusion.home.reason


def test_a_stop_on_the_way_home_ends_there_with_the_surveys_outcome() -> None:
    rover = away_from_home()
    rover.survey.abort(Outcome(RunStatus.PARTIAL, "enough"), home=True)
    while rover.survey.phase is not Phase.HOME:
        rover.step()
    rover.run(1.0)
    rover.survey.abort(Outcome(RunStatus.ABORTED, "ended by the operator"))
    rover.run(10.0)
    assert rover.survey.outcome == Outcome(RunStatus.PARTIAL, "enough")
    assert rover.survey.conclusion.home is not None
    assert rover.survey.conclusion.home.reason == "ended by the operator"
    assert distance_home(rover) > 0.2


def test_a_rover_that_never_left_is_at_home() -> None:
    rover = ImaginedRover(world=Imagined(sigma=5.0)).run(100.0)
    assert rover.survey.conclusion.home is not None
    assert rover.survey.conclusion.home.reached


def test_a_rover_whose_way_home_is_blocked_again_and_again_looks_around_before_it_gives_up() -> None:
    open_ground = np.ones((100, 100), bool)
    launch, far = Launch(Pose2(0.5, 0.5, 0.0), 0.25), Pose2(1.6, 1.6, 0.0)
    space = free_space(~open_ground, open_ground, 0.02, (), Area(2.0, 2.0, ()), launch, STANDARD)
    way = WayHome(launch.pose, 1)
    looks = 0
    while not way.given_up:
        looks += way.wants_look()
        assert not way.wants_look(), "once"
        assert way.path(space, far) is not None
    assert looks >= 1
    assert way.ways == MAX_WAYS
