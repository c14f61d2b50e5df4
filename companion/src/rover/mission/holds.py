"""What keeps the rover standing until somebody decides, or until it has passed: each with a line and a limit."""

from __future__ import annotations

import math
from dataclasses import dataclass

# What the operator's `pause` is called among the holds; it lasts until he says `go` or the mission's time is over.
PAUSE = "pause"
# A question to the operator, and how long it waits for the answer, seconds.
QUESTION = "question"
QUESTION_LIMIT_S = 600.0


@dataclass(frozen=True)
class Hold:
    """line: for the operator. until: companion time at which the mission ends for it, seconds."""

    line: str
    until: float = math.inf


class Holds:
    """Those of one mission, by name."""

    def __init__(self) -> None:
        self._holds: dict[str, Hold] = {}

    def __bool__(self) -> bool:
        return bool(self._holds)

    def __contains__(self, name: str) -> bool:
        return name in self._holds

    @property
    def line(self) -> str:
        """What is waited for; "" for nothing."""
        return "; ".join(hold.line for hold in self._holds.values())

    def add(self, name: str, line: str, until: float = math.inf) -> bool:
        """True when it is new."""
        if name in self._holds:
            return False
        self._holds[name] = Hold(line, until)
        return True

    def release(self, name: str) -> bool:
        """True when it was there."""
        return self._holds.pop(name, None) is not None

    def expired(self, now: float) -> str | None:
        """The line of one that has lasted for too long."""
        return next((hold.line for hold in self._holds.values() if now > hold.until), None)
