"""The mission file: TOML written by a person, read into frozen dataclasses; every mistake is one clear line."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from rover.errors import BadInput, NoPath
from rover.geometry import Pose2
from rover.link.baud import DEFAULT_BAUD
from rover.mission.beside import beside
from rover.mission.field import FIELD_KEYS, FieldSettings, read_field
from rover.mission.outline import STRIP_M, inside
from rover.report.projected import georeference
from rover.report.site import Georeference, GridPosition, Site
from rover.toml_file import read_toml
from rover.toml_table import Table
from rover.vehicle import STANDARD, Vehicle, load_vehicle
from rover.vision.camera.file import load_camera
from rover.vision.registration.steps import LOCALIZATION_STEPS, STEPS

SHIPPED = Path(__file__).resolve().parent.parent / "missions"
MAX_SIDE_M = 100.0
# An outline around less encloses no room for the rover.
MIN_AREA_M2 = 0.25
# How far outside the area a marker plate is still seen, and how near to each other two can be told apart, metres.
PLATES_BEYOND_M = 0.5
PLATES_APART_M = 1.5

# What tells the rover where it is: frames always do.
SOURCES = ("wheels", "frames")

SECTIONS = {
    "mission": ("name", "time_of_day", "max_duration_s", "goals", "required_coverage", "return_home"),
    "site": (
        *("name", "organisation", "operator", "date", "weather"),
        *("origin", "bearing_deg", "epsg", "easting", "northing"),
    ),
    "area": ("width_m", "height_m", "polygon", "exclude", "obstacles"),
    "launch": ("x_m", "y_m", "heading_deg", "surveyed_radius_m"),
    "rover": ("vehicle", "camera", "camera_source", "preprocess", "cruise_speed_m_s", "baud"),
    "localization": ("sources",),
    "markers": ("plates", "side_m"),
    "detector": ("model", "report_threshold", "keepout_radius_m", "standoff_m"),
    "field": FIELD_KEYS,
}


@dataclass(frozen=True)
class Area:
    """What to survey, in map: all of x in [0, width], y in [0, height], or a polygon in it; metres.

    obstacles: known beforehand (x, y, r). exclude: polygons that are neither surveyed nor entered.
    """

    width: float
    height: float
    obstacles: tuple[tuple[float, float, float], ...]
    polygon: tuple[tuple[float, float], ...] = ()
    exclude: tuple[tuple[tuple[float, float], ...], ...] = ()


@dataclass(frozen=True)
class Launch:
    """Where the operator sets the rover down, and how much ground around that he has surveyed himself."""

    pose: Pose2
    surveyed_radius: float


@dataclass(frozen=True)
class RoverSettings:
    """The rover that drives the mission; `camera_source` and `baud` matter on a real board.

    vehicle_file: where the vehicle is described, "" for the standard one. preprocess: names of STEPS.
    """

    vehicle: Vehicle
    vehicle_file: str
    camera: str
    camera_source: str
    preprocess: tuple[str, ...]
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
class Plates:
    """Marker plates, square, flat on the ground: where their middles lie in map, and their side; metres."""

    places: tuple[tuple[float, float], ...] = ()
    side: float = 0.20

    @property
    def radius(self) -> float:
        """From the middle to a corner, metres: no wheel comes nearer to a plate that has been seen."""
        return math.sqrt(0.5) * self.side


@dataclass(frozen=True)
class Mission:
    """A whole mission file. required_coverage: share of the ground that can be seen, from which a survey is done."""

    path: Path
    name: str
    time_of_day_s: float
    max_duration_s: float
    goals: tuple[tuple[float, float], ...]
    required_coverage: float
    return_home: bool
    site: Site
    area: Area
    launch: Launch
    rover: RoverSettings
    detector: DetectorSettings
    field: FieldSettings
    sources: tuple[str, ...] = SOURCES
    plates: Plates = Plates()


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
    top = Table(file, document).only(*SECTIONS)
    tables = {name: top.table(name).only(*keys) for name, keys in SECTIONS.items()}

    head = tables["mission"]
    rover = _rover(tables["rover"], file)
    area = _area(tables["area"])
    launch = _launch(tables["launch"], rover.vehicle)
    if area.polygon and not inside(area.polygon, (launch.pose.x, launch.pose.y)):
        area = _with_way_in(area, launch, tables["area"])
    mission = Mission(
        path=file,
        name=head.text("name", file.stem),
        time_of_day_s=head.clock_time("time_of_day", "13:00"),
        max_duration_s=head.number("max_duration_s", 1.0, 86_400.0, 900.0),
        goals=tuple((x, y) for x, y in head.rows("goals", ("x", "y"), -1e4, 1e4)),
        required_coverage=head.number("required_coverage", 0.0, 1.0, 0.98),
        return_home=head.flag("return_home", True),
        site=_site(tables["site"]),
        area=area,
        launch=launch,
        rover=rover,
        sources=_sources(tables["localization"]),
        plates=_plates(tables["markers"], area),
        detector=_detector(tables["detector"], file),
        field=read_field(tables["field"], area.width, area.height, file),
    )
    _check_places(mission)
    return mission


def _site(table: Table) -> Site:
    origin, grid = None, None
    if table.has("epsg"):
        grid, origin = _on_grid(table)
    elif table.has("origin"):
        latitude, longitude = table.row("origin", ("latitude", "longitude"), -180.0, 180.0)
        # At the poles no longitude is defined.
        if not abs(latitude) <= 89.0:
            raise table.error("origin", f"latitude {latitude:g} lies outside -89 to 89 deg")
        origin = Georeference(latitude, longitude, table.number("bearing_deg", -360.0, 360.0, 0.0))
    elif table.has("bearing_deg"):
        raise table.error("bearing_deg", "has no meaning without origin = [latitude, longitude], or epsg")
    return Site(
        name=table.text("name", ""),
        organisation=table.text("organisation", ""),
        operator=table.text("operator", ""),
        origin=origin,
        grid=grid,
        day=table.date("date") if table.has("date") else None,
        weather=table.text("weather", ""),
    )


def _on_grid(table: Table) -> tuple[GridPosition, Georeference]:
    if table.has("origin"):
        raise table.error("origin", "has no meaning beside epsg, easting and northing, which say the same")
    grid = GridPosition(
        table.integer("epsg", 1024, 32_767),
        table.number("easting", -1e8, 1e8),
        table.number("northing", -1e8, 1e8),
    )
    try:
        return grid, georeference(grid, table.number("bearing_deg", -360.0, 360.0, 0.0))
    except ValueError as error:
        raise table.error("epsg", str(error)) from None


def _area(table: Table) -> Area:
    obstacles = tuple((x, y, r) for x, y, r in table.rows("obstacles", ("x", "y", "radius"), -1e4, 1e4))
    exclude = table.outlines("exclude", 0.0, MAX_SIDE_M)
    if not table.has("polygon"):
        width, height = table.number("width_m", 1.0, MAX_SIDE_M), table.number("height_m", 1.0, MAX_SIDE_M)
        return Area(width, height, obstacles, exclude=exclude)
    for key in ("width_m", "height_m"):
        if table.has(key):
            raise table.error(key, "has no meaning beside polygon, which says how large the area is")
    polygon = table.outline("polygon", 0.0, MAX_SIDE_M)
    if abs(_signed_area(polygon)) < MIN_AREA_M2:
        raise table.error("polygon", f"must enclose at least {MIN_AREA_M2:g} m²")
    return Area(max(x for x, _ in polygon), max(y for _, y in polygon), obstacles, polygon, exclude)


def _with_way_in(area: Area, launch: Launch, table: Table) -> Area:
    """A map that reaches over the outline and over the way in from a launch outside."""
    aside = max(STRIP_M, launch.surveyed_radius)
    width, height = max(area.width, launch.pose.x + aside), max(area.height, launch.pose.y + aside)
    if max(width, height) > MAX_SIDE_M:
        raise table.error("polygon", f"with the launch beside it is larger than {MAX_SIDE_M:g} m")
    return replace(area, width=width, height=height)


def _signed_area(polygon: tuple[tuple[float, float], ...]) -> float:
    return 0.5 * sum(ax * by - bx * ay for (ax, ay), (bx, by) in zip(polygon, (*polygon[1:], polygon[0]), strict=True))


def _launch(table: Table, vehicle: Vehicle) -> Launch:
    x = table.number("x_m", -1e4, 1e4)
    y = table.number("y_m", -1e4, 1e4)
    heading = math.radians(table.number("heading_deg", -360.0, 360.0, 0.0))
    surveyed = table.number("surveyed_radius_m", vehicle.radius, 2.0, max(0.25, vehicle.radius))
    return Launch(Pose2(x, y, heading), surveyed)


def _rover(table: Table, file: Path) -> RoverSettings:
    vehicle, vehicle_file = STANDARD, table.text("vehicle", "")
    if vehicle_file:
        vehicle_file = beside(table, "vehicle", file, vehicle_file)
        try:
            vehicle = load_vehicle(Path(vehicle_file))
        except BadInput as error:
            raise table.error("vehicle", str(error)) from None
    camera = table.text("camera", vehicle.camera or "lepton-160")
    if camera.endswith(".toml"):
        camera = beside(table, "camera", file, camera)
    try:
        load_camera(camera)
    except BadInput as error:
        raise table.error("camera", str(error)) from None
    return RoverSettings(
        vehicle=vehicle,
        vehicle_file=vehicle_file,
        camera=camera,
        camera_source=table.text("camera_source", ""),
        preprocess=table.choices("preprocess", STEPS, LOCALIZATION_STEPS),
        cruise_speed=table.number("cruise_speed_m_s", 0.05, vehicle.travel.speed, min(0.25, vehicle.travel.speed)),
        baud=table.integer("baud", 9_600, 4_000_000, vehicle.baud or DEFAULT_BAUD),
    )


def _sources(table: Table) -> tuple[str, ...]:
    named = table.choices("sources", SOURCES, SOURCES)
    if "frames" not in named:
        raise table.error("sources", 'needs "frames": wheels alone lose their way within metres')
    return named


def _plates(table: Table, area: Area) -> Plates:
    places = tuple((x, y) for x, y in table.rows("plates", ("x", "y"), -1e4, 1e4))
    for number, (x, y) in enumerate(places, start=1):
        if not _inside(area, x, y, -PLATES_BEYOND_M):
            raise table.error(
                "plates",
                f"entry {number}: ({x:g}, {y:g}) lies more than {PLATES_BEYOND_M:g} m outside the area, "
                "where the camera never looks",
            )
        for other in places[: number - 1]:
            if math.dist((x, y), other) < PLATES_APART_M:
                raise table.error(
                    "plates",
                    f"entry {number}: ({x:g}, {y:g}) is nearer than {PLATES_APART_M:g} m to another one; "
                    "they could not be told apart",
                )
    return Plates(places, table.number("side_m", 0.12, 0.5, Plates().side))


def _detector(table: Table, file: Path) -> DetectorSettings:
    model = table.text("model", "")
    if model:
        model = beside(table, "model", file, model)
    return DetectorSettings(
        model=model,
        report_threshold=table.number("report_threshold", 0.01, 0.99, 0.3),
        keepout_radius=table.number("keepout_radius_m", 0.05, 2.0, 0.15),
        standoff=table.number("standoff_m", 0.2, 2.0, 0.45),
    )


def _check_places(mission: Mission) -> None:
    """Launch and goals must be inside the area and off every obstacle known beforehand."""
    radius = mission.rover.vehicle.radius
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
    if any(inside(hole, (launch.x, launch.y)) for hole in mission.area.exclude):
        raise BadInput(f"{mission.path}: [launch] x_m, y_m: ({launch.x:g}, {launch.y:g}) lies in an excluded part")
    for number, (gx, gy) in enumerate(mission.goals, start=1):
        outside = mission.area.polygon and not inside(mission.area.polygon, (gx, gy))
        if outside or not _inside(mission.area, gx, gy, 0.0):
            raise BadInput(
                f"{mission.path}: [mission] goals entry {number}: ({gx:g}, {gy:g}) lies outside the "
                + ("area's polygon" if outside else f"{mission.area.width:g} x {mission.area.height:g} m area")
            )
        if any(inside(hole, (gx, gy)) for hole in mission.area.exclude):
            raise BadInput(f"{mission.path}: [mission] goals entry {number}: ({gx:g}, {gy:g}) lies in an excluded part")
        for x, y, r in mission.area.obstacles:
            if math.hypot(gx - x, gy - y) < r:
                raise NoPath(
                    f"{mission.path}: [mission] goals entry {number}: ({gx:g}, {gy:g}) lies inside the obstacle "
                    f"at ({x:g}, {y:g}), r {r:g} m; move the goal or correct [area] obstacles"
                )


def _inside(area: Area, x: float, y: float, margin: float) -> bool:
    return margin <= x <= area.width - margin and margin <= y <= area.height - margin
