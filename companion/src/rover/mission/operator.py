"""What the operator says to a mission on its way, and what it answers."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rover.errors import BadInput
from rover.mission.commands import Command, Word
from rover.mission.goals import GoalState
from rover.mission.holds import PAUSE, QUESTION
from rover.outcome import Outcome, RunStatus

if TYPE_CHECKING:
    from rover.mission.survey import Survey

# Before this much is surveyed, and before this many seconds, nothing can be said about the rest.
FIRST_SHARE = 0.05
FIRST_S = 10.0


def tell(survey: Survey, now: float, command: Command) -> str:
    """Does what the operator wants; the answer is one line. Raises BadInput for a goal that is not there."""
    if survey.outcome is not None:
        raise BadInput("the mission is over")
    match command.word:
        case Word.PAUSE:
            survey.hold(now, PAUSE, "paused by the operator")
        case Word.GO:
            survey.holds.release(PAUSE)
            survey.holds.release(QUESTION)
        case Word.HOME:
            survey.conclusion.call_home(Outcome(RunStatus.ABORTED, "called home by the operator"))
            survey.holds.release(PAUSE)
        case Word.STOP:
            survey.abort(Outcome(RunStatus.ABORTED, "ended by the operator"))
        case Word.SKIP:
            _skip(survey, command.goal)
    survey.note(now, f"the operator says: {command.word} {command.goal}".rstrip())
    return situation(survey)


def situation(survey: Survey) -> str:
    """What the rover is about, one line."""
    if survey.outcome is not None:
        return f"{survey.outcome.status}: {survey.outcome.reason}"
    return f"{survey.phase}: {survey.holds.line}" if survey.holds else str(survey.phase)


def remaining_s(survey: Survey, now: float) -> float | None:
    """About how long the mission still takes, from what it has taken so far; None before anything can be said."""
    shown, taken = survey.coverage.surveyed_share(), survey.watch.lasted(now)
    if shown < FIRST_SHARE or taken < FIRST_S:
        return None
    back = survey.way_back_s() if survey.mission.return_home else 0.0
    return taken * (1.0 - shown) / shown + back


def _skip(survey: Survey, name: str) -> None:
    goal = survey.goals.named(name)
    if goal is None:
        names = ", ".join(goal.id for goal in survey.goals.pending) or "none"
        raise BadInput(f"skip {name}: no such goal; still to be inspected: {names}")
    if goal.state is GoalState.PENDING:
        goal.state, goal.reason = GoalState.SKIPPED, "skipped by the operator"
        survey.turn_away_from(goal)
