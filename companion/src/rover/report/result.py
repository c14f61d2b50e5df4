"""The result of a mission, as one value: summary.json, the map and the report are made of nothing else."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from rover.geometry import Pose2
from rover.outcome import RunStatus
from rover.record.epoch import NO_EPOCH, Epoch
from rover.report.site import UNKNOWN, Site
from rover.report.visits import TwoVisitsResult
from rover.str_enum import StrEnum
from rover.vehicle import STANDARD


class GoalKind(StrEnum):
    """Who set a goal: the mission file, or the rover to inspect an indication."""

    OPERATOR = "operator"
    INSPECTION = "inspection"


class ObstacleSource(StrEnum):
    """How an obstacle is known: from the mission file, or by what the rover saw."""

    GIVEN = "given"
    THERMAL = "thermal"
    TOUCHED = "touched"


@dataclass(frozen=True)
class DetectionResult:
    """An indication: something in the ground or on it that may be a mine.

    kind: "surface" or "buried". p: probability of that class. probabilities: of every class.
    sigma: 1σ radius in metres of its place in map; relative_sigma: among the ground around it. zone_radius: of the
    keep-out zone around it. inspected: looked at from an inspection pose; why_not: the reason when it was not.
    thumbnail: kelvin (h, w) around the place, or None.
    """

    id: int
    kind: str
    p: float
    x: float
    y: float
    sigma: float
    views: int
    zone_radius: float
    first_seen: float
    inspected: bool
    why_not: str = ""
    probabilities: dict[str, float] = field(default_factory=dict)
    thumbnail: NDArray[np.float32] | None = None
    relative_sigma: float | None = None


@dataclass(frozen=True)
class GoalResult:
    """A place to look at."""

    id: int
    x: float
    y: float
    reached: bool
    kind: GoalKind = GoalKind.OPERATOR
    reason: str = ""
    time: float | None = None


@dataclass(frozen=True)
class ObstacleResult:
    """A disc that was driven around."""

    x: float
    y: float
    radius: float
    source: ObstacleSource


@dataclass(frozen=True)
class Unsurveyed:
    """Ground of the area that was not surveyed, with the reason, in m²."""

    area: float
    reason: str


@dataclass(frozen=True)
class Coverage:
    """Share of the ground that could be seen which was seen, 0 to 1.

    by_truth: by the referee of a simulated rig; otherwise by the rover's own map, which may be wrong.
    """

    share: float
    required: float
    by_truth: bool

    def __str__(self) -> str:
        whose = "by the truth" if self.by_truth else "by the rover's own map"
        return f"{100.0 * self.share:.1f} % of the ground that can be seen, {whose}"


@dataclass(frozen=True)
class HomeResult:
    """Whether the rover stands at its launch in the end, and why or why not."""

    reached: bool
    reason: str


@dataclass(frozen=True)
class Safety:
    """What the referee of a simulated rig counted; None where nobody could count (a real field).

    collisions: contacts harder than 0.1 m/s; bumper_contacts: the softer ones and what the bumper felt.
    """

    collisions: int | None = None
    keepout_violations: int | None = None
    unseen_ground: float | None = None
    min_clearance: float | None = None
    wheel_over_mine: int | None = None
    bumper_contacts: int = 0


@dataclass(frozen=True)
class Found:
    """What the referee of a simulated rig says of the indications: it knows where the mines lie.

    with_contrast: mines that show in a thermal picture at all. false: indications where no mine is.
    """

    mines: int
    found: int
    with_contrast: int
    with_contrast_found: int
    false: int

    def __str__(self) -> str:
        hidden = self.mines - self.with_contrast
        shown = f" ({self.with_contrast_found} of {self.with_contrast} that show)" if hidden else ""
        return f"{self.found} of {self.mines}{shown}, {self.false} false"


@dataclass(frozen=True)
class PlateResult:
    """A marker plate. seen: the map is tied to it; off: how far from it the map was at its first sight, metres."""

    x: float
    y: float
    seen: bool
    off: float | None = None


@dataclass(frozen=True)
class Localization:
    """How well the rover knew where it was: RMS errors in metres (simulated rigs), fixes of the camera.

    ate_rmse, sigma: in map, which is tied to the launch and to the plates that were seen; relative_rmse, inside_95,
    max_relative_sigma: among the things and the ground around the rover (`rover.record.relative_error`).
    """

    ate_rmse: float | None = None
    odometry_only_ate_rmse: float | None = None
    fixes: int = 0
    rejected: int = 0
    final_sigma: float | None = None
    max_sigma: float | None = None
    relative_rmse: float | None = None
    inside_95: float | None = None
    max_relative_sigma: float | None = None
    plates: tuple[PlateResult, ...] = ()

    @property
    def held_by(self) -> str:
        """What the position in map is measured from."""
        seen = sum(plate.seen for plate in self.plates)
        return f"launch and {seen} of {len(self.plates)} plates" if self.plates else "launch"


@dataclass(frozen=True)
class TimelineEntry:
    """Something worth telling that happened at `time` seconds of the mission."""

    time: float
    text: str


@dataclass(frozen=True, eq=False)
class MapLayers:
    """Rasters in map; row 0 is at `origin[1]` (the bottom), all of one shape (h, w).

    temperature: kelvin, nan where nothing was seen. seen, occupied: bool.
    """

    origin: tuple[float, float]
    resolution: float
    temperature: NDArray[np.float32]
    seen: NDArray[np.bool_]
    occupied: NDArray[np.bool_]


@dataclass(frozen=True)
class Identities:
    """What was at work: so that a result can be traced and repeated."""

    rig: str
    seed: int | None
    rover_version: str
    firmware_version: str = ""
    firmware_git_hash: str = ""
    board: str = ""
    schema_hash: str = ""
    model_hash: str = ""
    mission_hash: str = ""
    source_hash: str = ""
    camera: str = ""
    camera_hash: str = ""
    vehicle_hash: str = ""
    # The folder's name of the run that this one went on from.
    after: str = ""

    @property
    def simulated(self) -> bool:
        """True for rigs with a simulated field."""
        return self.rig in ("sitl", "emulator")


@dataclass(frozen=True)
class WallClock:
    """The only figures that differ from run to run."""

    duration: float
    speed_factor: float


@dataclass(frozen=True)
class RealTime:
    """How well a mission on a real rover kept its time. longest_cycle in seconds; frames_dropped: not looked at."""

    cycles: int
    overruns: int
    longest_cycle: float
    frames_dropped: int


@dataclass(frozen=True, eq=False)
class RunResult:
    """A whole mission. reason: one sentence that an operator understands.

    path: (N, 3) time, x, y of the estimated trajectory in map. Times in seconds of mission time.
    """

    mission: str
    status: RunStatus
    reason: str
    duration: float
    distance: float
    area_width: float
    area_height: float
    launch: Pose2
    path: NDArray[np.float64]
    layers: MapLayers
    identities: Identities
    site: Site = UNKNOWN
    # When times of this result are zero.
    epoch: Epoch = NO_EPOCH
    detections: tuple[DetectionResult, ...] = ()
    goals: tuple[GoalResult, ...] = ()
    obstacles: tuple[ObstacleResult, ...] = ()
    unsurveyed: tuple[Unsurveyed, ...] = ()
    surveyed_area: float = 0.0
    # Ground that the wheels have pressed, each piece once, m².
    fresh_wheel: float = 0.0
    # Of the area to survey, m²; None: all of width by height.
    wanted_area: float | None = None
    coverage: Coverage | None = None
    # None: the run was cut off, nobody knows.
    home: HomeResult | None = None
    safety: Safety = Safety()
    found: Found | None = None
    localization: Localization = Localization()
    link: dict[str, float] = field(default_factory=dict)
    timeline: tuple[TimelineEntry, ...] = ()
    final_pose: Pose2 | None = None
    robot_radius: float = STANDARD.radius
    wall_clock: WallClock | None = None
    real_time: RealTime | None = None
    out: str = ""
    # Mission time at which the log ends that this was recovered from, seconds.
    recovered_until: float | None = None
    # What could not be written, a line each.
    unwritten: tuple[str, ...] = ()
    # Of a second visit: what it says together with the first.
    visits: TwoVisitsResult | None = None

    @property
    def area_m2(self) -> float:
        """What was to be surveyed."""
        return self.area_width * self.area_height if self.wanted_area is None else self.wanted_area

    @property
    def exit_code(self) -> int:
        """Exit code of the command that ran the mission."""
        return self.status.exit_code
