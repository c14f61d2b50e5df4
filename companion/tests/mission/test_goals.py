"""Goals: the operator's points, and one for every suspected place."""

from __future__ import annotations

from dataclasses import dataclass

from rover.detection.place import Anchor
from rover.mission.goals import Goals, GoalState


@dataclass(frozen=True)
class Place:
    id: int
    x: float
    y: float
    anchor: Anchor | None = None


def states(goals: Goals) -> dict[str, GoalState]:
    return {goal.id: goal.state for goal in goals}


def test_the_operators_points_are_goals_from_the_start() -> None:
    goals = Goals([(1.0, 2.0), (2.0, 1.0)])
    assert [(goal.id, goal.x, goal.y, goal.place_id) for goal in goals.pending] == [
        ("operator-1", 1.0, 2.0, None),
        ("operator-2", 2.0, 1.0, None),
    ]


def test_every_suspected_place_becomes_one_goal_and_stays_one() -> None:
    goals = Goals([(1.0, 2.0)])
    for _ in range(3):
        goals.update([Place(7, 2.0, 3.0), Place(3, 1.0, 1.0)])
    assert [goal.id for goal in goals] == ["operator-1", "place-7", "place-3"]


def test_a_goal_follows_its_place() -> None:
    goals = Goals([])
    goals.update([Place(1, 2.0, 3.0)])
    goals.update([Place(1, 2.1, 3.2)])
    assert [(goal.x, goal.y) for goal in goals] == [(2.1, 3.2)]


def test_evidence_against_a_place_drops_its_goal_and_new_evidence_brings_it_back() -> None:
    goals = Goals([(1.0, 1.0)])
    goals.update([Place(1, 2.0, 3.0)])
    goals.update([])
    assert states(goals) == {"operator-1": GoalState.PENDING, "place-1": GoalState.DISMISSED}
    assert next(goal.reason for goal in goals if goal.place_id == 1) == "evidence went against it"
    goals.update([Place(1, 2.0, 3.0)])
    assert states(goals)["place-1"] == GoalState.PENDING
    assert all(goal.reason == "" for goal in goals)


def test_what_was_inspected_or_given_up_stays_so() -> None:
    goals = Goals([])
    goals.update([Place(1, 2.0, 3.0), Place(2, 1.0, 1.0)])
    for goal, state in zip(goals, (GoalState.INSPECTED, GoalState.UNREACHABLE), strict=True):
        goal.state = state
    goals.update([])
    goals.update([Place(1, 2.0, 3.0), Place(2, 1.0, 1.0)])
    assert states(goals) == {"place-1": GoalState.INSPECTED, "place-2": GoalState.UNREACHABLE}
    assert goals.pending == []


def test_another_run_goes_on_with_what_is_inspected_and_tries_again_what_was_given_up() -> None:
    former = Goals([(0.0, 0.0), (2.0, 2.0), (1.0, 2.0)])
    former.update([Place(1, 2.0, 3.0), Place(2, 1.0, 1.0)])
    inspected, unreachable = GoalState.INSPECTED, GoalState.UNREACHABLE
    former_states = (inspected, unreachable, inspected, inspected, unreachable)
    for goal, state in zip(former, former_states, strict=True):
        goal.state = state
    goals = Goals([(0.0, 0.0), (2.0, 2.0), (1.5, 2.5)])
    goals.restore(former)
    assert states(goals) == {
        "operator-1": GoalState.INSPECTED,
        "operator-2": GoalState.PENDING,
        "operator-3": GoalState.PENDING,
        "place-1": GoalState.INSPECTED,
        "place-2": GoalState.PENDING,
    }
