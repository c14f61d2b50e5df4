"""Reads a vehicle file, and checks what stands in it against each other."""

from __future__ import annotations

import math
from pathlib import Path

from rover_protocol.parameters import BY_NAME

from rover.errors import BadInput
from rover.toml_table import Table
from rover.vehicle.firmware import Q15, keys_of, read_settings
from rover.vehicle.model import SONARS, STANDARD, STANDARD_SLOPE_DEG, Limits, Pack, SonarMount, Vehicle

EXAMPLE = Path(__file__).parent / "example.toml"

TABLES = {
    "body": ("radius_m", "slope_deg"),
    "wheels": ("track_m", "radius_m", "right_radius_m", "counts_per_revolution"),
    "travel": ("speed_m_s", "acceleration_m_s2", "jerk_m_s3"),
    "battery": ("cells", "capacity_wh", "resistance_ohm", "power_w", "low_v", *keys_of("battery")),
    "turning": ("speed_rad_s", "acceleration_rad_s2", "jerk_rad_s3"),
    "drive": keys_of("drive"),
    "camera": ("file",),
    "wire": ("baud",),
}
SONAR_KEYS = ("x_m", "y_m", "yaw_deg", "half_angle_deg")
# Of a lithium-ion cell: below the first it is harmed, above the second it is nearly full.
CELL_V = (2.8, 3.7)
# Seconds that a stop from full speed may take.
LONGEST_STOP_S = 2.0
# From the ping that first hears an obstacle: three slots until the sensor's next turn, and 30 ms of median and loop.
GUARD_SLOTS, GUARD_MS = 3, 30


def load_vehicle(path: Path) -> Vehicle:
    """The vehicle that a TOML file describes; what it leaves out is as on the standard rover.

    Raises BadInput for anything wrong in the file, also for values that do not fit each other.
    """
    top = Table.of_file(path).only(*TABLES, "sonar", "wiring", "firmware")
    tables = {name: top.table(name).only(*keys) for name, keys in TABLES.items()}
    wheels = tables["wheels"]
    radius = wheels.number("radius_m", 0.005, 0.5, STANDARD.wheel_radius)
    vehicle = Vehicle(
        radius=tables["body"].number("radius_m", 0.05, 2.0, STANDARD.radius),
        max_slope=math.radians(tables["body"].number("slope_deg", 1.0, 45.0, STANDARD_SLOPE_DEG)),
        track_width=wheels.number("track_m", 0.05, 1.0, STANDARD.track_width),
        wheel_radius=radius,
        right_wheel_radius=wheels.number("right_radius_m", 0.8 * radius, 1.25 * radius, radius),
        counts_per_revolution=wheels.integer("counts_per_revolution", 4, 1_000_000, STANDARD.counts_per_revolution),
        travel=_limits(tables["travel"], TABLES["travel"], STANDARD.travel),
        heading=_limits(tables["turning"], TABLES["turning"], STANDARD.heading),
        pack=_pack(tables["battery"]),
        sonars=_sonars(top) if top.has("sonar") else STANDARD.sonars,
        settings=read_settings(top),
        camera=_camera(tables["camera"], path),
        baud=tables["wire"].integer("baud", 1200, 4_000_000) if tables["wire"].has("baud") else None,
    )
    _check(vehicle, tables, top)
    return vehicle


def _check(vehicle: Vehicle, tables: dict[str, Table], top: Table) -> None:
    """What each key allows by itself and all of them together do not."""
    if vehicle.wheel_reach > vehicle.radius:
        reach = f"the wheels reach {vehicle.wheel_reach:g} m from the centre"
        raise tables["body"].error("radius_m", f"{reach}: the body's disc of {vehicle.radius:g} m must hold them")
    values = vehicle.parameters()
    for name in ("count_left", "count_right"):
        if not BY_NAME[name].minimum <= values[name] <= BY_NAME[name].maximum:
            raise tables["wheels"].error(
                "counts_per_revolution", f"a count of {values[name]} pm: not for this firmware"
            )
    outer = vehicle.travel.speed + 0.5 * vehicle.track_width * vehicle.heading.speed
    if values["feed_velocity"] and outer > (reach_m_s := (Q15 - values["feed_static"]) / values["feed_velocity"]):
        raise tables["travel"].error(
            "speed_m_s",
            f"with {vehicle.heading.speed:g} rad/s {vehicle.travel.speed:g} m/s is {outer:.2f} m/s at the outer wheel, "
            f"which reaches {reach_m_s:.2f} m/s at full duty by [drive]",
        )
    _check_limits(vehicle, values, tables)
    wanted = GUARD_SLOTS * values["sonar_slot"] + GUARD_MS
    if values["guard_latency"] < wanted - 1:
        slot = f"with a sonar_slot of {values['sonar_slot']} ms"
        raise top.table("firmware").error(
            "guard_latency", f"{slot} a range is {wanted} ms old when it counts: too small"
        )
    a_cell = vehicle.pack.low_v / vehicle.pack.cells
    if not CELL_V[0] <= a_cell <= CELL_V[1]:
        cells = (
            f"is {a_cell:.2f} V for each of {vehicle.pack.cells} cells, {CELL_V[0]} to {CELL_V[1]} V are for lithium"
        )
        raise tables["battery"].error("low_v", f"{vehicle.pack.low_v:g} V {cells}")


def _check_limits(vehicle: Vehicle, values: dict[str, int], tables: dict[str, Table]) -> None:
    """The firmware must let pass what is planned, and be able to stop it."""
    for table, limits, axis in (("travel", vehicle.travel, "travel"), ("turning", vehicle.heading, "heading")):
        keys = TABLES[table]
        for key, planned, name in (
            (keys[0], limits.speed, f"max_{axis}_velocity"),
            (keys[1], limits.acceleration, f"max_{axis}_acceleration"),
        ):
            if planned * 1e6 > values[name]:
                most = f"the firmware refuses more than its {name}, {values[name] * 1e-6:g}"
                raise tables[table].error(key, f"{planned:g} is planned with, and {most}")
        acceleration, jerk = (values[f"stop_{axis}_{name}"] * 1e-6 for name in ("acceleration", "jerk"))
        lasts = limits.speed / acceleration + acceleration / jerk
        if lasts > LONGEST_STOP_S:
            slow = f"stop_{axis}_acceleration {acceleration:g} and stop_{axis}_jerk {jerk:g}"
            raise tables[table].error(
                keys[0], f"with {slow} a stop from it takes {lasts:.1f} s, {LONGEST_STOP_S:g} at most"
            )


def _camera(table: Table, path: Path) -> str:
    """Name of a built-in camera, or a camera file beside the vehicle's."""
    name = table.text("file", "")
    if not name.endswith(".toml"):
        return name
    return str((path.parent / name).resolve())


def _limits(table: Table, keys: tuple[str, ...], standard: Limits) -> Limits:
    speed, acceleration, jerk = keys
    return Limits(
        table.number(speed, 0.01, 10.0, standard.speed),
        table.number(acceleration, 0.01, 50.0, standard.acceleration),
        table.number(jerk, 0.1, 500.0, standard.jerk),
    )


def _pack(table: Table) -> Pack:
    standard = STANDARD.pack
    cells = table.integer("cells", 1, 14, standard.cells)
    return Pack(
        cells=cells,
        capacity_wh=table.number("capacity_wh", 0.1, 5000.0, standard.capacity_wh),
        resistance_ohm=table.number("resistance_ohm", 0.0, 5.0, standard.resistance_ohm),
        power_w=table.number("power_w", 0.1, 2000.0, standard.power_w),
        low_v=table.number("low_v", 1.0, 60.0, standard.low_v * cells / standard.cells),
    )


def _sonars(top: Table) -> tuple[SonarMount, ...]:
    tables = top.tables("sonar")
    if len(tables) != SONARS:
        raise top.error("sonar", f"must be {SONARS} tables [[sonar]]: left, centre and right, not {len(tables)}")
    return tuple(_sonar(table.only(*SONAR_KEYS)) for table in tables)


def _sonar(table: Table) -> SonarMount:
    return SonarMount(
        x=table.number("x_m", -2.0, 2.0),
        y=table.number("y_m", -2.0, 2.0),
        yaw=math.radians(table.number("yaw_deg", -180.0, 180.0)),
        half_angle=math.radians(table.number("half_angle_deg", 1.0, 45.0, 15.0)),
    )


def example() -> str:
    """The commented file of the standard rover. Raises BadInput when it is not installed."""
    try:
        return EXAMPLE.read_text(encoding="utf-8")
    except OSError as error:
        raise BadInput(f"{EXAMPLE}: {error.strerror}: install the package anew") from None
