"""Stops by the firmware: how many of which kind a mission goes on after."""

from __future__ import annotations

from collections import Counter

from rover.link.words import StopCause
from rover.mission.field import FULL_FIELD_M2
from rover.outcome import Outcome, RunStatus

# Stops of one cause after which the rover is armed again; of a cause that is not named here, none.
MAX_REARMS: dict[str, int] = {
    StopCause.SONAR_GUARD: 30,
    StopCause.BUMPER: 10,
    StopCause.STOP_COMMAND: 100,
    StopCause.UNDERRUN: 5,
    StopCause.DEAD_MAN: 3,
    StopCause.STALL: 3,
    # Once the sensor answers again.
    StopCause.SENSOR_LOST: 3,
}

# Of these the ground has so many for every FULL_FIELD_M2: a larger field has more rocks to come near to.
BY_AREA = (StopCause.SONAR_GUARD, StopCause.BUMPER, StopCause.STOP_COMMAND)

# Causes after which the field can be gone on with once the rover has been looked after.
RESUMABLE = (StopCause.LOW_BATTERY,)

# Seconds between the latch and the new arming: the rover has come to rest and the pose has settled.
REARM_DELAY_S = 0.4


class Stops:
    """Counts the firmware's stops of one mission, by cause."""

    def __init__(self, area_m2: float = FULL_FIELD_M2) -> None:
        """area_m2: what is to be surveyed."""
        self._size = max(area_m2 / FULL_FIELD_M2, 1.0)
        self._counts: Counter[str] = Counter()
        # Cause of the last one.
        self.last = ""

    def add(self, cause: str) -> None:
        """One more."""
        self.last = cause
        self._counts[cause] += 1

    def outcome(self, cause: str) -> Outcome:
        """How a mission ends that does not go on after a stop of this cause."""
        status = RunStatus.PARTIAL if cause in RESUMABLE else RunStatus.SAFETY_STOP
        return Outcome(status, f"the firmware stopped the rover: {cause}")

    def too_many(self, cause: str) -> bool:
        """True when the mission must not go on after another stop of this cause."""
        return self._counts[cause] > MAX_REARMS.get(cause, 0) * (self._size if cause in BY_AREA else 1.0)
