"""The mission file: TOML written by a person, read into frozen dataclasses; every mistake is one clear line."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rover.errors import BadInput, NoPath
from rover.geometry import Pose2
from rover.link.baud import DEFAULT_BAUD
from rover.toml_file import printable, read_toml
from rover.toml_table import Table
from rover.vehicle import Vehicle
from rover.vision.camera.file import load_camera

SHIPPED = Path(__file__).resolve().parent.parent / "missions"
SOILS = ("dry-sand", "loam", "clay", "moist-clay")
SECTIONS = {
    "mission": ("name", "time_of_day", "max_duration_s", "goals"),
    "area": ("width_m", "height_m", "obstacles"),
    "launch": ("x_m", "y_m", "heading_deg", "surveyed_radius_m"),
    "rover": ("camera", "camera_source", "cruise_speed_m_s", "baud"),
    "detector": ("model", "report_threshold", "keepout_radius_m", "standoff_m"),
    "field": ("soil", "rocks", "grass", "surface_mines", "buried_mine_depths_cm"),
}


@dataclass(frozen=True)
class Area:
    """The rectangle to survey, in map: x in [0, width], y in [0, height]; obstacles known beforehand (x, y, r)."""

    width: float
    height: float
    obstacles: tuple[tuple[float, float, float], ...]


@dataclass(frozen=True)
class Launch:
    """Where the operator sets the rover down, and how much ground around that he has surveyed himself."""

    pose: Pose2
    surveyed_radius: float


@dataclass(frozen=True)
class RoverSettings:
    """The rover that drives the mission; `camera_source` and `baud` matter on a real board."""

    camera: str
    camera_source: str
    cruise_speed: float
    baud: int


@dataclass(frozen=True)
class DetectorSettings:
    """The model and what is done with its answers; distances in metres."""

    model: str
    report_threshold: float
    keepout_radius: float
    standoff: float


@dataclass(frozen=True)
class FieldSettings:
    """What lies in the simulated field; only simulated rigs read it."""

    soil: str
    rocks: int
    grass: int
    surface_mines: int
    buried_mine_depths: tuple[float, ...]


@dataclass(frozen=True)
class Mission:
    """A whole mission file."""

    path: Path
    name: str
    time_of_day_s: float
    max_duration_s: float
    goals: tuple[tuple[float, float], ...]
    area: Area
    launch: Launch
    rover: RoverSettings
    detector: DetectorSettings
    field: FieldSettings


def load(path: str | Path) -> Mission:
    """Reads and checks a mission file; a bare name such as "demo" means one that ships with the project.

    Raises BadInput for anything wrong in the file, NoPath for a goal that lies inside a known obstacle.
    """
    given = Path(path)
    shipped = SHIPPED / f"{given.name}.toml"
    file = shipped if given.suffix == "" and not os.path.exists(given) and os.path.exists(shipped) else given
    return from_document(read_toml(file), file)


def from_document(document: dict[str, Any], file: Path) -> Mission:
    """The mission that a file's content describes; other files that it names lie beside `file`. Raises as `load`."""
    for name in document:
        if name not in SECTIONS:
            raise BadInput(f"{file}: [{printable(name)}]: unknown section; known are {', '.join(SECTIONS)}")
    tables = {name: Table(file, document.get(name, {}), name).only(*keys) for name, keys in SECTIONS.items()}

    area = _area(tables["area"])
    head = tables["mission"]
    mission = Mission(
        path=file,
        name=head.text("name", file.stem),
        time_of_day_s=head.clock_time("time_of_day", "13:00"),
        max_duration_s=head.number("max_duration_s", 1.0, 86_400.0, 900.0),
        goals=tuple((x, y) for x, y in head.rows("goals", ("x", "y"), -1e4, 1e4)),
        area=area,
        launch=_launch(tables["launch"]),
        rover=_rover(tables["rover"], file),
        detector=_detector(tables["detector"], file),
        field=_field(tables["field"]),
    )
    _check_places(mission)
    return mission


def _area(table: Table) -> Area:
    return Area(
        width=table.number("width_m", 1.0, 100.0),
        height=table.number("height_m", 1.0, 100.0),
        obstacles=tuple((x, y, r) for x, y, r in table.rows("obstacles", ("x", "y", "radius"), -1e4, 1e4)),
    )


def _launch(table: Table) -> Launch:
    x = table.number("x_m", -1e4, 1e4)
    y = table.number("y_m", -1e4, 1e4)
    heading = math.radians(table.number("heading_deg", -360.0, 360.0, 0.0))
    return Launch(Pose2(x, y, heading), table.number("surveyed_radius_m", Vehicle().radius, 2.0, 0.25))


def _beside(table: Table, key: str, file: Path, name: str) -> str:
    """A file named in a mission file, relative to that file."""
    try:
        path = (file.parent / name).resolve()
        found = path.is_file()
    except (OSError, ValueError):
        raise table.error(key, f"{name!r} is no file name") from None
    if not found:
        raise table.error(key, f"{path}: no such file")
    return str(path)


def _rover(table: Table, file: Path) -> RoverSettings:
    camera = table.text("camera", "lepton-160")
    if camera.endswith(".toml"):
        camera = _beside(table, "camera", file, camera)
    try:
        load_camera(camera)
    except BadInput as error:
        raise table.error("camera", str(error)) from None
    return RoverSettings(
        camera=camera,
        camera_source=table.text("camera_source", ""),
        cruise_speed=table.number("cruise_speed_m_s", 0.05, Vehicle().travel.speed, 0.25),
        baud=table.integer("baud", 9_600, 4_000_000, DEFAULT_BAUD),
    )


def _detector(table: Table, file: Path) -> DetectorSettings:
    model = table.text("model", "")
    if model:
        model = _beside(table, "model", file, model)
    return DetectorSettings(
        model=model,
        report_threshold=table.number("report_threshold", 0.01, 0.99, 0.3),
        keepout_radius=table.number("keepout_radius_m", 0.05, 2.0, 0.15),
        standoff=table.number("standoff_m", 0.2, 2.0, 0.45),
    )


def _field(table: Table) -> FieldSettings:
    depths = table.numbers("buried_mine_depths_cm", 0.5, 15.0, [1.0, 2.0, 5.0])
    return FieldSettings(
        soil=table.choice("soil", SOILS, "loam"),
        rocks=table.integer("rocks", 0, 200, 5),
        grass=table.integer("grass", 0, 200, 4),
        surface_mines=table.integer("surface_mines", 0, 100, 2),
        buried_mine_depths=tuple(depth / 100.0 for depth in depths),
    )


def _check_places(mission: Mission) -> None:
    """Launch and goals must be inside the area and off every obstacle known beforehand."""
    radius = Vehicle().radius
    launch = mission.launch.pose
    if not _inside(mission.area, launch.x, launch.y, radius):
        raise BadInput(
            f"{mission.path}: [launch] x_m, y_m: ({launch.x:g}, {launch.y:g}) is nearer than the rover's radius "
            f"of {radius:g} m to the border of the {mission.area.width:g} x {mission.area.height:g} m area"
        )
    for x, y, r in mission.area.obstacles:
        if r <= 0.0:
            raise BadInput(f"{mission.path}: [area] obstacles: radius {r:g} of ({x:g}, {y:g}) must be above 0")
        if math.hypot(launch.x - x, launch.y - y) < r + radius:
            raise NoPath(
                f"{mission.path}: [launch]: the rover would stand in the obstacle at ({x:g}, {y:g}), r {r:g} m; "
                "move the launch or correct [area] obstacles"
            )
    for number, (gx, gy) in enumerate(mission.goals, start=1):
        if not _inside(mission.area, gx, gy, 0.0):
            raise BadInput(
                f"{mission.path}: [mission] goals entry {number}: ({gx:g}, {gy:g}) lies outside the "
                f"{mission.area.width:g} x {mission.area.height:g} m area"
            )
        for x, y, r in mission.area.obstacles:
            if math.hypot(gx - x, gy - y) < r:
                raise NoPath(
                    f"{mission.path}: [mission] goals entry {number}: ({gx:g}, {gy:g}) lies inside the obstacle "
                    f"at ({x:g}, {y:g}), r {r:g} m; move the goal or correct [area] obstacles"
                )


def _inside(area: Area, x: float, y: float, margin: float) -> bool:
    return margin <= x <= area.width - margin and margin <= y <= area.height - margin
