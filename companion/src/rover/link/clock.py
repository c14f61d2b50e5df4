"""The companion's time, behind one small interface, so that the same loop runs on a desk and in virtual time."""

from __future__ import annotations

import time
from typing import Protocol


class Clock(Protocol):
    """A source of time in seconds that the caller may wait on."""

    def now(self) -> float:
        """Seconds since the session began."""
        ...

    def advance(self, to: float) -> None:
        """Returns when `now()` has reached `to`; at once if it already has."""
        ...


class WallClock:
    """Real time for real devices: monotonic seconds since the clock was made."""

    def __init__(self) -> None:
        self.origin = time.monotonic()

    def now(self) -> float:
        """Seconds since the clock was made."""
        return time.monotonic() - self.origin

    def advance(self, to: float) -> None:
        """Sleeps until `to`."""
        remaining = to - self.now()
        if remaining > 0.0:
            time.sleep(remaining)
