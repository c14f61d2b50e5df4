"""What the end of a mission means: `done`, and everything else."""

from __future__ import annotations

import numpy as np
import pytest
from rover.mission.ending import judged, percent
from rover.mission.goals import Goal, GoalState
from rover.outcome import RunStatus

from companion.tests.mission.imagined_rover import Imagined, ImaginedRover, a_mission

INSPECTED = Goal("operator-1", 1.0, 1.0, None, GoalState.INSPECTED)
UNREACHABLE = Goal("operator-2", 1.0, 1.0, None, GoalState.UNREACHABLE)
SKIPPED = Goal("place-3", 1.0, 1.0, 3, GoalState.SKIPPED)
PLACE = Goal("place-4", 1.0, 1.0, 4, GoalState.UNREACHABLE)


@pytest.mark.parametrize(
    ("coverage", "goals", "status", "why"),
    [
        (0.98, [], RunStatus.DONE, "nothing is left"),
        (1.0, [INSPECTED, UNREACHABLE, PLACE], RunStatus.DONE, "nothing is left"),
        (1.0, [PLACE], RunStatus.DONE, "nothing is left"),
        (0.9799, [INSPECTED], RunStatus.PARTIAL, "97.9 % of the ground that can be seen was seen, 98 % are required"),
        (1.0, [UNREACHABLE], RunStatus.PARTIAL, "none of the operator's goals could be reached"),
        (1.0, [INSPECTED, SKIPPED], RunStatus.PARTIAL, "skipped by the operator: place-3"),
    ],
)
def test_done_is_coverage_reached_and_every_goal_settled(
    coverage: float, goals: list[Goal], status: RunStatus, why: str
) -> None:
    outcome = judged(coverage, 0.98, goals)
    assert outcome.status is status
    assert why in outcome.reason


def test_a_percentage_is_never_rounded_up_to_what_is_required() -> None:
    assert percent(0.97999) == "97.9 %"
    assert percent(0.98) == "98 %"


def test_ground_that_no_picture_shows_is_missing_however_little_of_it_can_be_reached() -> None:
    """Nobody can go far: by what was seen alone the rover would know of nothing more to see."""
    rover = ImaginedRover(world=Imagined(shows=False)).run(300.0)
    assert rover.survey.outcome is not None
    assert rover.survey.outcome.status is RunStatus.PARTIAL
    assert rover.survey.outcome.status.exit_code == 8
    assert rover.survey.own_coverage() < 0.2


def test_a_mission_file_may_ask_for_less() -> None:
    rover = ImaginedRover(a_mission(mission={"required_coverage": 0.0}), Imagined(shows=False)).run(300.0)
    assert rover.survey.outcome is not None
    assert rover.survey.outcome.status is RunStatus.DONE


def test_ground_shut_off_by_obstacles_is_not_asked_for() -> None:
    rover = ImaginedRover(a_mission(height=4.0))
    rover.perception.grid.occupied[100:106] = True
    rover.run(600.0)
    assert not rover.perception.grid.seen[165:].any()
    assert rover.survey.outcome is not None
    assert rover.survey.outcome.status is RunStatus.DONE, rover.survey.outcome.reason


def test_only_the_polygon_is_surveyed_from_a_launch_outside_of_it() -> None:
    outline = [[1.0, 0.0], [2.6, 0.0], [2.6, 2.0], [1.0, 2.0]]
    hole = [[2.0, 1.4], [2.6, 1.4], [2.6, 2.0], [2.0, 2.0]]
    mission = a_mission(area={"polygon": outline, "exclude": [hole]})
    rover = ImaginedRover(mission)
    track = []
    while rover.survey.outcome is None and rover.now < 600.0:
        rover.step()
        track.append((rover.perception.pose.x, rover.perception.pose.y))
    assert rover.survey.outcome is not None
    assert rover.survey.outcome.status is RunStatus.DONE, rover.survey.outcome.reason
    shown = rover.perception.grid.seen & rover.survey.coverage.wanted
    assert shown.sum() >= 0.98 * rover.survey.coverage.wanted.sum()
    assert not any(x > 1.9 and y > 1.5 for x, y in track)
    assert np.ptp([x for x, _ in track]) > 0.5
