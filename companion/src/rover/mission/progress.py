"""The rule against standing still: no state of a mission lasts without motion, a decision, or an end with a reason.

Motion is what the wheels have turned, not what was commanded. A rover that stands for LOOK_AFTER_S though it may turn
looks around, so that pictures from other headings can tell it more; when that has brought no decision for MAX_LOOKS
times, or when nothing at all has happened for END_AFTER_S, the mission ends. Decisions that lead nowhere are counted,
too: a rover may not go back and forth for ever.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from enum import Enum, auto

from rover.link.telemetry import Telemetry, WheelMotion
from rover.vehicle import Vehicle

# Seconds of standing after which a rover that may turn looks around. An inspection takes 1 s, planning less.
LOOK_AFTER_S = 5.0
# Seconds of standing after which the mission ends, whatever it waits for: longer than the camera's own patience.
END_AFTER_S = 40.0
# Looks around in a row that lead to no drive.
MAX_LOOKS = 2
# Drives in a row that bring nothing: no ground shown, no goal settled.
MAX_IDLE_DRIVES = 25
# Wheel travel that counts as motion, metres; half a degree of turning is as much.
MOTION_M = 0.002


class Duty(Enum):
    """What the rule asks for now."""

    NOTHING = auto()
    LOOK = auto()
    END = auto()


class Odometer:
    """Metres that the wheels have rolled, forwards or backwards, the mean of both."""

    def __init__(self, vehicle: Vehicle) -> None:
        self._scale = 0.5 * vehicle.metres_per_count
        self._counts: tuple[int, int] | None = None
        self.travel = 0.0

    def take(self, telemetry: Iterable[Telemetry]) -> None:
        """One cycle's telemetry."""
        for event in telemetry:
            if isinstance(event, WheelMotion):
                counts = (event.left_counts, event.right_counts)
                before = self._counts or counts
                self.travel += self._scale * (abs(counts[0] - before[0]) + abs(counts[1] - before[1]))
                self._counts = counts


class Progress:
    """Times are seconds of the companion's clock."""

    def __init__(self) -> None:
        self._since: float | None = None
        self._travel = -math.inf
        self._looks = 0
        self._gain = 0
        self._idle_drives = 0

    @property
    def looked(self) -> bool:
        """Whether the rover has looked around since its last drive."""
        return self._looks > 0

    def decided(self, now: float) -> None:
        """A decision was taken: the mission is in another phase, or the operator has spoken."""
        self._since = now

    def looks_around(self, now: float) -> None:
        """The rover begins to look around, for whatever reason."""
        self._looks += 1
        self.decided(now)

    def drives(self, now: float, gain: int) -> None:
        """A drive begins. `gain`: a count that grows with everything that is found out or done."""
        self._looks = 0
        self._idle_drives = 0 if gain > self._gain else self._idle_drives + 1
        self._gain = max(self._gain, gain)
        self.decided(now)

    def check(self, now: float, travel: float, may_turn: bool) -> Duty:
        """Called every cycle. `travel`: of the wheels, metres; `may_turn`: at rest, armed, and the camera sees."""
        if self._since is None or travel - self._travel >= MOTION_M:
            self._since, self._travel = now, travel
        if self._idle_drives > MAX_IDLE_DRIVES:
            return Duty.END
        still = now - self._since
        if still > END_AFTER_S:
            return Duty.END
        if still > LOOK_AFTER_S and may_turn:
            return Duty.LOOK if self._looks < MAX_LOOKS else Duty.END
        return Duty.NOTHING

    def reason(self, waiting_for: str) -> str:
        """Why the rule ends the mission, as one sentence."""
        if self._idle_drives > MAX_IDLE_DRIVES:
            return f"{self._idle_drives} drives in a row showed no new ground and settled no goal"
        looked = f", {self._looks} looks around changed nothing" if self._looks else ""
        return f"the rover stood still: {waiting_for}{looked}"
