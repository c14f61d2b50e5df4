"""The section [field] of a mission file: what a simulated field holds, and what it does to the rover on it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from rover.mission.beside import beside
from rover.toml_table import Table

# How things lie in a simulated field: apart, with room to drive, or as it comes.
PLACEMENTS = ("spaced", "random")
SOILS = ("dry-sand", "loam", "clay", "moist-clay")
# What lies in a simulated field of FULL_FIELD_M2 or more where the mission file does not say.
DEFAULT_ROCKS = 5
DEFAULT_GRASS = 4
DEFAULT_SURFACE_MINES = 2
DEFAULT_DEPTHS_CM = (1.0, 2.0, 5.0)
# Smaller fields get fewer, narrow ones as well; below MIN_FIELD_SIDE_M nothing can lie that the rover gets past.
FULL_FIELD_M2 = 12.0
FULL_FIELD_SIDE_M = 2.0
MIN_FIELD_SIDE_M = 1.2
FIELD_KEYS = (
    *("soil", "rocks", "grass", "surface_mines", "buried_mine_depths_cm"),
    *("placement", "world", "inertial_sensor"),
)


@dataclass(frozen=True)
class FieldSettings:
    """What lies in the simulated field, and what the rover is like there; only simulated rigs read it.

    world: path of the file that says how unfriendly it is, or the name of one that ships with the rigs; "" for none.
    inertial_sensor: the simulated rover has one.
    """

    soil: str
    rocks: int
    grass: int
    surface_mines: int
    buried_mine_depths: tuple[float, ...]
    placement: str = "spaced"
    world: str = ""
    inertial_sensor: bool = False


def read_field(table: Table, width: float, height: float, file: Path) -> FieldSettings:
    """Of an area of these sides, metres, in the mission file `file`. Raises BadInput."""
    share = _default_share(width, height)
    mines = round((DEFAULT_SURFACE_MINES + len(DEFAULT_DEPTHS_CM)) * share)
    buried = round(mines * len(DEFAULT_DEPTHS_CM) / (DEFAULT_SURFACE_MINES + len(DEFAULT_DEPTHS_CM)))
    depths = table.numbers("buried_mine_depths_cm", 0.5, 15.0, DEFAULT_DEPTHS_CM[:buried])
    world = table.text("world", "")
    return FieldSettings(
        soil=table.choice("soil", SOILS, "loam"),
        rocks=table.integer("rocks", 0, 200, round(DEFAULT_ROCKS * share)),
        grass=table.integer("grass", 0, 200, round(DEFAULT_GRASS * share)),
        surface_mines=table.integer("surface_mines", 0, 100, mines - buried),
        buried_mine_depths=tuple(depth / 100.0 for depth in depths),
        placement=table.choice("placement", PLACEMENTS, PLACEMENTS[0]),
        world=beside(table, "world", file, world) if world.endswith(".toml") else world,
        inertial_sensor=table.flag("inertial_sensor", False),
    )


def _default_share(width: float, height: float) -> float:
    """How much of the full default field fits into an area with room to drive: 1 from FULL_FIELD_M2 on."""
    side = min(width, height)
    if side < MIN_FIELD_SIDE_M:
        return 0.0
    return min(1.0, width * height / FULL_FIELD_M2) * min(1.0, side / FULL_FIELD_SIDE_M)
