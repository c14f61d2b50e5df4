"""The rover's dimensions and limits, as the companion plans with them: the standard rover's, or those of a file.

The firmware holds its own copy as parameters and the plant as its configuration; a test keeps the three equal.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

from rover.toml_table import Table

# How far beyond the middle of a wheel its tyre reaches: half as wide and half as long as its contact, with a little
# more for a tyre that gives.
TYRE_REACH_M = 0.02

TABLES = {
    "body": ("radius_m",),
    "wheels": ("track_m", "radius_m", "counts_per_revolution"),
    "travel": ("speed_m_s", "acceleration_m_s2", "jerk_m_s3"),
    "battery": ("cells", "capacity_wh", "resistance_ohm", "power_w", "low_v"),
    "turning": ("speed_rad_s", "acceleration_rad_s2", "jerk_rad_s3"),
}
SONAR_KEYS = ("x_m", "y_m", "yaw_deg", "half_angle_deg")
# The firmware knows a left, a centre and a right one.
SONARS = 3


@dataclass(frozen=True)
class SonarMount:
    """Where an HC-SR04 sits on base_link, and the half-angle of its cone."""

    x: float
    y: float
    yaw: float
    half_angle: float = math.radians(15.0)


@dataclass(frozen=True)
class Limits:
    """Bounds of one axis of motion: speed, acceleration, jerk (SI)."""

    speed: float
    acceleration: float
    jerk: float


@dataclass(frozen=True)
class Pack:
    """A lithium-ion battery, from which the companion reckons how far it still lasts.

    power_w: drawn on average while driving; low_v: at which the firmware stops the rover.
    """

    cells: int = 2
    capacity_wh: float = 19.0
    resistance_ohm: float = 0.15
    power_w: float = 12.0
    low_v: float = 6.2


@dataclass(frozen=True)
class Vehicle:
    """Differential drive inside a disc; metres, radians, seconds. Sonars: left, centre, right."""

    radius: float = 0.15
    track_width: float = 0.20
    wheel_radius: float = 0.0325
    counts_per_revolution: int = 1560
    travel: Limits = Limits(0.25, 0.5, 3.0)
    heading: Limits = Limits(1.2, 3.0, 8.0)
    sonars: tuple[SonarMount, ...] = (
        SonarMount(0.10, 0.06, math.radians(30.0)),
        SonarMount(0.12, 0.0, 0.0),
        SonarMount(0.10, -0.06, math.radians(-30.0)),
    )

    pack: Pack = Pack()

    @property
    def metres_per_count(self) -> float:
        """Wheel travel per encoder count."""
        return 2.0 * math.pi * self.wheel_radius / self.counts_per_revolution

    @property
    def wheel_reach(self) -> float:
        """The furthest that a tyre reaches from the rover's centre; whole micrometres."""
        return round(0.5 * self.track_width + TYRE_REACH_M, 6)

    @property
    def rolls_like_standard(self) -> bool:
        """True when wheels and sonars are those of the standard rover, which is what the simulated rigs are."""
        own = (self.track_width, self.wheel_radius, self.counts_per_revolution, self.sonars)
        return own == (STANDARD.track_width, STANDARD.wheel_radius, STANDARD.counts_per_revolution, STANDARD.sonars)


STANDARD = Vehicle()


def load_vehicle(path: Path) -> Vehicle:
    """The vehicle that a TOML file describes; what it leaves out is as on the standard rover.

    Raises BadInput for anything wrong in the file.
    """
    top = Table.of_file(path).only(*TABLES, "sonar")
    body, wheels, travel, battery, turning = (top.table(name).only(*keys) for name, keys in TABLES.items())
    vehicle = Vehicle(
        radius=body.number("radius_m", 0.05, 2.0, STANDARD.radius),
        track_width=wheels.number("track_m", 0.05, 1.0, STANDARD.track_width),
        wheel_radius=wheels.number("radius_m", 0.005, 0.5, STANDARD.wheel_radius),
        counts_per_revolution=wheels.integer("counts_per_revolution", 4, 1_000_000, STANDARD.counts_per_revolution),
        travel=_limits(travel, TABLES["travel"], STANDARD.travel),
        heading=_limits(turning, TABLES["turning"], STANDARD.heading),
        pack=_pack(battery),
        sonars=_sonars(top) if top.has("sonar") else STANDARD.sonars,
    )
    if vehicle.wheel_reach > vehicle.radius:
        reach = f"the wheels reach {vehicle.wheel_reach:g} m from the centre"
        raise body.error("radius_m", f"{reach}: the body's disc of {vehicle.radius:g} m must hold them")
    return vehicle


def _limits(table: Table, keys: tuple[str, ...], standard: Limits) -> Limits:
    speed, acceleration, jerk = keys
    return Limits(
        table.number(speed, 0.01, 10.0, standard.speed),
        table.number(acceleration, 0.01, 50.0, standard.acceleration),
        table.number(jerk, 0.1, 500.0, standard.jerk),
    )


def _pack(table: Table) -> Pack:
    standard = STANDARD.pack
    return Pack(
        cells=table.integer("cells", 1, 14, standard.cells),
        capacity_wh=table.number("capacity_wh", 0.1, 5000.0, standard.capacity_wh),
        resistance_ohm=table.number("resistance_ohm", 0.0, 5.0, standard.resistance_ohm),
        power_w=table.number("power_w", 0.1, 2000.0, standard.power_w),
        low_v=table.number("low_v", 1.0, 60.0, standard.low_v),
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
