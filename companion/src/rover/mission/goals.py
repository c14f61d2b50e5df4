"""What the mission still has to inspect: the operator's points and every suspected place."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

from rover.mission.keepout import SuspectedPlace
from rover.str_enum import StrEnum

# Arrivals that brought no view of the goal, after which it is given up, with the reason in the report.
MAX_ATTEMPTS = 3


class GoalState(StrEnum):
    """What has become of a goal; the values stand in a run's survey file."""

    PENDING = "pending"
    INSPECTED = "inspected"
    UNREACHABLE = "unreachable"
    # The operator has said so.
    SKIPPED = "skipped"
    # The ground there has proved to be plain: nothing is left to inspect.
    DISMISSED = "dismissed"


@dataclass
class Goal:
    """A point in map (metres) that is inspected from a stand-off, never driven on."""

    id: str
    x: float
    y: float
    place_id: int | None
    state: GoalState = GoalState.PENDING
    reason: str = ""
    attempts: int = 0
    inspected_at: float | None = None


class Goals:
    """All goals of a mission, in the order in which they arose."""

    def __init__(self, operator_points: Iterable[tuple[float, float]]) -> None:
        self._goals = [Goal(f"operator-{n}", x, y, None) for n, (x, y) in enumerate(operator_points, start=1)]

    def __iter__(self) -> Iterator[Goal]:
        return iter(self._goals)

    @property
    def pending(self) -> list[Goal]:
        """Goals that still want a visit."""
        return [goal for goal in self._goals if goal.state is GoalState.PENDING]

    @property
    def settled(self) -> int:
        """How many do not."""
        return len(self._goals) - len(self.pending)

    def update(self, suspected: Iterable[SuspectedPlace]) -> None:
        """Adds a goal for every new place, moves the others along, drops those no longer suspected."""
        places = {place.id: place for place in suspected}
        for goal in self._goals:
            if goal.place_id is None:
                continue
            place = places.pop(goal.place_id, None)
            if place is None:
                if goal.state is GoalState.PENDING:
                    goal.state, goal.reason = GoalState.DISMISSED, "evidence went against it"
                continue
            goal.x, goal.y = place.x, place.y
            if goal.state is GoalState.DISMISSED:
                goal.state, goal.reason = GoalState.PENDING, ""
        for place in places.values():
            self._goals.append(Goal(f"place-{place.id}", place.x, place.y, place.id))

    def restore(self, former: Iterable[Goal]) -> None:
        """Takes over another run's goals: of the operator's points those that are wanted now, too.

        What was inspected stays so; what was given up is tried again.
        """
        wanted = {(goal.x, goal.y): goal for goal in self._goals}
        for goal in former:
            if goal.place_id is not None:
                anew = replace(goal, attempts=0, inspected_at=None)
                if goal.state in (GoalState.UNREACHABLE, GoalState.SKIPPED):
                    anew.state, anew.reason = GoalState.PENDING, ""
                self._goals.append(anew)
            elif goal.state is GoalState.INSPECTED and (goal.x, goal.y) in wanted:
                wanted[goal.x, goal.y].state = GoalState.INSPECTED

    def named(self, name: str) -> Goal | None:
        """The goal of that name (`place-3`), or with that number in the summary's list; None when there is none."""
        numbered = dict(enumerate(self._goals, start=1))
        wanted = name.strip()
        by_number = numbered.get(int(wanted)) if wanted.isdecimal() and len(wanted) < 9 else None
        return next((goal for goal in self._goals if goal.id == wanted), by_number)


def judge_inspection(goal: Goal, viewed: bool, now: float) -> str | None:
    """Settles a goal that was looked at once more; what is to be told of it, if anything."""
    goal.attempts += 1
    if goal.state is not GoalState.PENDING:
        return None
    if viewed:
        goal.state, goal.inspected_at = GoalState.INSPECTED, now
        return f"{goal.id} inspected"
    if goal.attempts >= MAX_ATTEMPTS:
        goal.state, goal.reason = GoalState.UNREACHABLE, f"not in view from {goal.attempts} inspection poses"
        return f"{goal.id} given up: {goal.reason}"
    return None
