"""What the end of a mission means: `done` is coverage reached and every goal settled, everything else is `partial`."""

from __future__ import annotations

from collections.abc import Sequence

from rover.mission.goals import Goal, GoalState
from rover.outcome import Outcome, RunStatus

ALL_DONE = "every goal is inspected or shown to be unreachable, and nothing is left to see"


def judged(coverage: float, required: float, goals: Sequence[Goal]) -> Outcome:
    """How a mission ends that knows of nothing more to do. `coverage`, `required`: shares, 0 to 1."""
    by_operator = [goal for goal in goals if goal.place_id is None]
    if by_operator and not any(goal.state is GoalState.INSPECTED for goal in by_operator):
        return Outcome(RunStatus.PARTIAL, "none of the operator's goals could be reached")
    if skipped := [goal.id for goal in goals if goal.state is GoalState.SKIPPED]:
        return Outcome(RunStatus.PARTIAL, f"skipped by the operator: {', '.join(skipped)}")
    return Outcome(RunStatus.DONE, ALL_DONE) if coverage >= required else short_of(coverage, required)


def short_of(coverage: float, required: float) -> Outcome:
    """Too little was seen."""
    return Outcome(
        RunStatus.PARTIAL,
        f"{percent(coverage)} of the ground that can be seen was seen, {percent(required)} are required; "
        "no way is known to more",
    )


def percent(share: float) -> str:
    """Rounded down to a tenth: 97.99 % are not 98 %."""
    return f"{int(1000.0 * share + 1e-9) / 10.0:g} %"
