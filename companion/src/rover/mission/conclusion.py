"""How a mission will end, and where: what was asked for first counts, and the rover drives home unless it must stay."""

from __future__ import annotations

from dataclasses import dataclass, replace

from rover.geometry import Pose2
from rover.mission.home import Home, WayHome
from rover.outcome import Outcome, RunStatus

NOT_ASKED = "the mission file says return_home = false"


@dataclass(frozen=True)
class Ending:
    """How a mission will end, once at rest or at home. stay: why it ends where the rover stands; "" to drive back."""

    outcome: Outcome
    stay: str = ""


class Conclusion:
    """Of one mission. end: None while it goes on; home: known once it has ended."""

    def __init__(self, way: WayHome, return_home: bool) -> None:
        self.way = way
        self.end: Ending | None = None
        self.home: Home | None = None
        self._return_home = return_home

    def ask(self, outcome: Outcome, home: bool = False) -> None:
        """The mission is to end with this outcome; with `home` the rover drives back first, if the mission says so.

        On the way home the outcome stays what it was: only the way back is given up.
        """
        if self.end is None:
            stay = "" if home and self._return_home else NOT_ASKED if home else outcome.reason
            self.end = Ending(outcome, stay)
        elif not home:
            self.stay(outcome.reason)

    def call_home(self, outcome: Outcome) -> None:
        """The operator wants the rover back, whatever the mission file says."""
        self.end = replace(self.end or Ending(outcome), stay="")

    def stay(self, why: str) -> None:
        """The rover must not drive any more; a mission that was not to end is `partial` for that."""
        self.end = self.end or Ending(Outcome(RunStatus.PARTIAL, why))
        if not self.end.stay:
            self.end = replace(self.end, stay=why)

    def settle(self, pose: Pose2) -> Outcome:
        """The rover stands where it will be left. `stay` or `ask` must have been called."""
        assert self.end is not None
        there = self.way.reached(pose)
        self.home = Home(there, "at the launch" if there else self.end.stay)
        return self.end.outcome
