"""What the rules beside a survey (`vigilance`, `halting`) know of it and may ask of it."""

from __future__ import annotations

import math
from typing import Protocol

from rover.mission.checks import Checks
from rover.mission.conclusion import Conclusion
from rover.mission.config import Mission
from rover.mission.contacts import Contacts
from rover.mission.drive import Drive
from rover.mission.energy import Gauge
from rover.mission.holds import Holds
from rover.mission.perception import Perception
from rover.mission.phase import Event, Phase
from rover.mission.progress import Odometer
from rover.mission.stops import Stops
from rover.mission.watch import Watch
from rover.outcome import Outcome
from rover.vehicle import Vehicle


class Conduct(Protocol):
    """A mission on its way; see `rover.mission.survey.Survey`. since: when the phase began, seconds."""

    mission: Mission
    vehicle: Vehicle
    perception: Perception
    contacts: Contacts
    drive: Drive
    phase: Phase
    since: float
    attended: bool
    conclusion: Conclusion
    holds: Holds
    watch: Watch
    stops: Stops
    odometer: Odometer
    checks: Checks
    gauge: Gauge

    def note(self, now: float, text: str) -> None: ...
    def happen(self, event: Event, now: float) -> None: ...
    def heed(self, now: float) -> None: ...
    def hold(self, now: float, name: str, line: str, until: float = math.inf) -> None: ...
    def abort(self, outcome: Outcome, home: bool = False) -> None: ...
    def conclude(self, now: float) -> None: ...
    def way_back_s(self) -> float: ...
