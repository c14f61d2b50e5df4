"""A rover that is only imagined: the survey's orders move it, and a test says what it knows, sees and answers.

Nothing of it is estimated: what stands in `Imagined` is what the survey is told.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray
from rover.capture.frame import Frame
from rover.geometry import Pose2
from rover.link.telemetry import Battery, FirmwareState, Telemetry, WheelMotion
from rover.link.words import MotorState, StopCause
from rover.mapping.survey_grid import SurveyGrid
from rover.mission.checks import Checks
from rover.mission.config import Mission, from_document
from rover.mission.goals import Goal
from rover.mission.handling import Handling
from rover.mission.inertial import Inertial
from rover.mission.keepout import KeepOut, Zone
from rover.mission.orders import Orders
from rover.mission.perception import PLACED_SIGMA, Perception
from rover.mission.phase import Phase
from rover.mission.survey import Survey
from rover.outcome import Outcome
from rover.vehicle import STANDARD
from rover.vision.localization.fix import Fix

CYCLE = 0.1
VIEW = np.array([[0.15, -0.15], [1.0, -0.6], [1.0, 0.6], [0.15, 0.15]])
PICTURE = np.full((4, 4), 30_000, np.uint16)


def a_mission(width: float = 2.0, height: float = 2.0, **tables: dict[str, Any]) -> Mission:
    document: dict[str, Any] = {
        "area": {"width_m": width, "height_m": height},
        "launch": {"x_m": 0.5, "y_m": 0.5, "heading_deg": 45.0},
        "mission": {"max_duration_s": 3000.0},
    }
    for name, table in tables.items():
        document[name] = table if "polygon" in table else {**document.get(name, {}), **table}
    return from_document(document, Path("imagined.toml"))


@dataclass
class Imagined:
    """What is the case now. wheels: whether they turn as commanded; shows: whether pictures show new ground."""

    sigma: float = 0.01
    frames: bool = True
    shutter: bool = False
    shows: bool = True
    wheels: bool = True
    speaks: bool = True
    state: str = MotorState.ARMED
    cause: str = StopCause.NONE
    faults: tuple[str, ...] = ()
    volts: float = 7.6


class ImaginedPerception:
    """Is a `Perception` as far as a survey asks for one."""

    def __init__(self, mission: Mission, world: Imagined) -> None:
        self._world = world
        self.grid = SurveyGrid(mission.area.width, mission.area.height)
        self.keepout = KeepOut(mission.detector.keepout_radius)
        self.pose = mission.launch.pose
        self.battery: Battery | None = None
        self.released: set[int] = set()
        self.last_fix: Fix | None = None
        self.suspected: list[Any] = []
        self.footprint = VIEW
        self.handling = Handling(STANDARD)
        self.inertial = Inertial()
        self._views = 0

    @property
    def sigma(self) -> float:
        return 0.0

    @property
    def relative_sigma(self) -> float:
        return self._world.sigma

    @property
    def placed(self) -> bool:
        return self.relative_sigma <= PLACED_SIGMA

    @property
    def zones(self) -> list[Zone]:
        return self.keepout.active

    def shift(self) -> None:
        return None

    def speed_limit(self, x: float, y: float) -> float:
        return math.inf

    def take(self, event: Telemetry) -> None:
        self.handling.take(event)
        self.inertial.take(event)
        if isinstance(event, Battery):
            self.battery = event

    def see(self, frame: Frame, now: float) -> bool:
        if frame.ffc or not self.placed:
            return False
        self._views += 1
        if self._world.shows:
            self.grid.seen |= self.in_view(self.pose)
        self.grid.changed(self.grid.area)
        return True

    def in_view(self, pose: Pose2) -> NDArray[np.bool_]:
        return Perception.in_view(cast(Perception, self), pose)

    @property
    def _footprint(self) -> np.ndarray:
        return VIEW

    def count_views(self, goal: Goal) -> None:
        self._views = 0

    def was_viewed(self, goal: Goal) -> bool:
        return self._views >= 4


@dataclass
class ImaginedRover:
    """Survey and world, cycle by cycle. at_rest_since: when the wheels last turned."""

    mission: Mission = field(default_factory=a_mission)
    world: Imagined = field(default_factory=Imagined)
    now: float = 0.0

    def __post_init__(self) -> None:
        self.perception = ImaginedPerception(self.mission, self.world)
        self.survey = Survey(self.mission, STANDARD, cast(Perception, self.perception), seed=1)
        self.survey.checks = Checks(late_s=1.5 * CYCLE)
        self.orders = Orders()
        self.moved = False
        # What the firmware says besides, in the next cycle.
        self.said: list[Telemetry] = []
        self._counts = [0.0, 0.0]
        self._sequence = 0

    def step(self) -> Orders:
        """One cycle."""
        before, self.now = self.now, self.now + CYCLE
        world = self.world
        self._drive(before)
        left, right = (round(count / STANDARD.metres_per_count) for count in self._counts)
        telemetry: list[Telemetry] = [WheelMotion(self.now, left, right), Battery(self.now, world.volts, world.volts)]
        telemetry += self.said
        self.said = []
        self._sequence += 1
        frames = [Frame(PICTURE, self.now, self._sequence, world.shutter)] if world.frames else []
        firmware = None
        if world.speaks:
            armed = world.state in (MotorState.ARMED, MotorState.MOVING)
            firmware = FirmwareState(self.now, world.state, world.cause, 0, world.faults, 1, True, False, False, armed)
        self.orders = self.survey.step(self.now, telemetry, frames, firmware)
        return self.orders

    def run(self, seconds: float) -> ImaginedRover:
        """Until that much time has passed, or the mission ends."""
        end = self.now + seconds
        while self.now < end and self.survey.outcome is None:
            self.step()
        return self

    def become(self, **changes: Any) -> None:
        """The world is another from now on."""
        for name, value in vars(replace(self.world, **changes)).items():
            setattr(self.world, name, value)

    @property
    def phase(self) -> Phase:
        return self.survey.phase

    @property
    def outcome(self) -> Outcome | None:
        return self.survey.outcome

    def has_ended(self) -> bool:
        return self.survey.outcome is not None

    @property
    def notes(self) -> list[str]:
        return [text for _, text in self.survey.timeline]

    def _drive(self, before: float) -> None:
        """What the wheels do of what was committed for this cycle."""
        self.moved = False
        if not self.world.wheels or self.world.state not in (MotorState.ARMED, MotorState.MOVING):
            return
        pose = self.perception.pose
        for travel, turn in self.survey.drive.committed.increments(before, self.now):
            middle = pose.heading + 0.5 * turn
            pose = Pose2(pose.x + travel * math.cos(middle), pose.y + travel * math.sin(middle), pose.heading + turn)
            self._counts[0] += travel - 0.5 * turn * STANDARD.track_width
            self._counts[1] += travel + 0.5 * turn * STANDARD.track_width
            self.moved = self.moved or abs(travel) + abs(turn) > 1e-6
        self.perception.pose = pose
