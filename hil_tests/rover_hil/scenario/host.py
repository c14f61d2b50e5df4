"""The companion's computer: its clock, which may jump, and its process, which may freeze or be killed."""

from __future__ import annotations

from collections.abc import Callable

from rover_hil.scenario.driver import Killed


class Host:
    """Is the `Clock` of the companion's link. `step` lets the world run for one step and returns its time, seconds."""

    def __init__(self, step: Callable[[], float]) -> None:
        self._step = step
        self._world = 0.0
        self._offset = 0.0
        self._killed = False
        self.frozen = False
        self.on_wake: Callable[[float], None] = lambda now: None

    def now(self) -> float:
        """The companion's time, seconds."""
        return self._world + self._offset

    def from_world(self, time: float) -> float:
        """The companion's time at a time of the world."""
        return time + self._offset

    def advance(self, to: float) -> None:
        """Returns when `now()` has reached `to`; later when the process was frozen meanwhile. Raises Killed."""
        while self.now() < to - 1e-9 or self.frozen:
            frozen = self.frozen
            self._world = self._step()
            if self._killed:
                raise Killed
            if frozen and not self.frozen:
                self.on_wake(self._world)

    def jump(self, seconds: float) -> None:
        """The clock shows so much more, or less, from now on."""
        self._offset += seconds

    def kill(self) -> None:
        """The process is gone with the next step."""
        self._killed = True
