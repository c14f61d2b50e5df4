"""What the operator says to a mission on its way."""

from __future__ import annotations

import pytest
from rover.errors import BadInput
from rover.mission.commands import Command, Word
from rover.mission.goals import GoalState
from rover.mission.operator import remaining_s, situation, tell
from rover.mission.phase import Phase
from rover.outcome import RunStatus

from companion.tests.mission.imagined_rover import ImaginedRover, a_mission


def driving(**mission: object) -> ImaginedRover:
    rover = ImaginedRover(a_mission(3.0, 3.0, mission={"goals": [[2.0, 2.0]], **mission}))
    while rover.phase is not Phase.DRIVE:
        rover.step()
    rover.run(0.5)
    return rover


def say(rover: ImaginedRover, word: Word, goal: str = "") -> str:
    return tell(rover.survey, rover.now, Command(word, goal))


def test_a_paused_rover_stands_however_long_and_goes_on_when_it_is_told_to() -> None:
    rover = driving()
    say(rover, Word.PAUSE)
    rover.run(3.0)
    assert situation(rover.survey) == "paused: paused by the operator"
    there = rover.perception.pose
    rover.run(200.0)
    assert not rover.has_ended()
    assert rover.perception.pose == there
    assert situation(rover.survey) == "paused: paused by the operator"
    say(rover, Word.GO)
    rover.run(5.0)
    assert rover.phase is not Phase.PAUSED
    rover.run(600.0)
    assert rover.outcome is not None
    assert rover.outcome.status is RunStatus.DONE


def test_a_paused_rover_does_not_drive_home_by_itself_when_the_time_is_over() -> None:
    rover = driving(max_duration_s=100.0)
    say(rover, Word.PAUSE)
    rover.run(200.0)
    assert rover.outcome is not None
    assert rover.outcome.status is RunStatus.PARTIAL
    assert rover.survey.conclusion.home is not None
    assert rover.survey.conclusion.home.reason == "paused by the operator"


def test_home_drives_home_even_where_the_mission_file_does_not_ask_for_it() -> None:
    rover = driving(return_home=False)
    say(rover, Word.HOME)
    rover.run(60.0)
    assert rover.outcome is not None
    assert (rover.outcome.status, rover.outcome.reason) == (
        RunStatus.ABORTED,
        "called home by the operator",
    )
    assert rover.survey.conclusion.home is not None
    assert rover.survey.conclusion.home.reached


def test_stop_ends_where_the_rover_stands() -> None:
    rover = driving()
    say(rover, Word.STOP)
    rover.run(10.0)
    assert rover.outcome is not None
    assert rover.outcome.status is RunStatus.ABORTED
    assert rover.survey.conclusion.home is not None
    assert not rover.survey.conclusion.home.reached


@pytest.mark.parametrize("name", ["operator-1", "1"])
def test_a_goal_that_is_skipped_is_not_inspected_and_the_mission_is_partial(name: str) -> None:
    rover = driving()
    say(rover, Word.SKIP, name)
    rover.run(600.0)
    (goal,) = rover.survey.goals
    assert (goal.state, goal.reason) == (GoalState.SKIPPED, "skipped by the operator")
    assert rover.outcome is not None
    assert rover.outcome.status is RunStatus.PARTIAL


@pytest.mark.parametrize("name", ["place-9", "", "99999999999999999999", "-1", "²"])
def test_a_goal_that_is_not_there_is_refused_with_those_that_are(name: str) -> None:
    rover = driving()
    with pytest.raises(BadInput, match="no such goal; still to be inspected: operator-1"):
        say(rover, Word.SKIP, name)
    assert rover.survey.conclusion.end is None


def test_nothing_can_be_said_to_a_mission_that_is_over() -> None:
    rover = driving()
    say(rover, Word.STOP)
    rover.run(10.0)
    with pytest.raises(BadInput, match="over"):
        say(rover, Word.GO)


def test_what_is_said_stands_in_the_timeline() -> None:
    rover = driving()
    say(rover, Word.PAUSE)
    say(rover, Word.SKIP, "operator-1")
    assert "the operator says: skip operator-1" in rover.notes
    assert "the operator says: pause" in rover.notes


def test_the_time_that_is_left_is_unknown_at_first_and_falls_towards_the_end() -> None:
    rover = ImaginedRover(a_mission(3.0, 3.0))
    rover.run(2.0)
    assert remaining_s(rover.survey, rover.now) is None
    rover.run(15.0)
    early = remaining_s(rover.survey, rover.now)
    rover.run(30.0)
    late = remaining_s(rover.survey, rover.now)
    assert early is not None
    assert late is not None
    assert early > late > 0.0


@pytest.mark.parametrize("attended", [True, False])
def test_after_a_gap_of_the_companion_somebody_decides_before_the_rover_drives(attended: bool) -> None:
    rover = driving()
    rover.survey.attended = attended
    rover.now += 25.0
    rover.step()
    there = rover.perception.pose
    rover.run(100.0)
    if not attended:
        assert rover.outcome is not None
        assert rover.outcome.status is RunStatus.PARTIAL
        assert "stood still for 25 s" in rover.outcome.reason
        return
    assert not rover.has_ended()
    assert rover.perception.pose.distance(there) < 0.3
    say(rover, Word.GO)
    rover.run(600.0)
    assert rover.outcome is not None
    assert rover.outcome.status is RunStatus.DONE


def test_a_question_that_nobody_answers_ends_the_mission() -> None:
    rover = driving()
    rover.survey.attended = True
    rover.now += 25.0
    rover.run(900.0)
    assert rover.outcome is not None
    assert rover.outcome.status is RunStatus.PARTIAL
    assert "nothing came of waiting" in rover.outcome.reason
