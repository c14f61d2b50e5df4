"""Numbers that tools or languages force into two places are the same in both."""

from __future__ import annotations

import json
import math
import re
import sys
from pathlib import Path

import pytest
import rover
from rover.link.baud import DEFAULT_BAUD
from rover.mission.config import from_document
from rover.mission.keepout import MINE_RADIUS_M as KEPT_OFF_M
from rover.vehicle import Vehicle
from rover_hil.ground.placement import MINE_KEEP_OUT_M
from rover_hil.ground.signature import MINE_RADIUS_M, SURFACE_MINE_RADII_M
from rover_hil.referee import PATCH_M
from rover_hil.testing.pins import pins_constant
from rover_protocol.parameters import BY_NAME

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROOT = Path(__file__).resolve().parents[2]
VEHICLE = Vehicle()


def text(path: str) -> str:
    return (ROOT / path).read_text(encoding="utf-8")


def number(source: str, pattern: str) -> float:
    found = re.search(pattern, source)
    assert found, pattern
    return float(found.group(1).replace("_", ""))


def parameter(name: str) -> int:
    """Default of a firmware parameter, in its own unit."""
    return BY_NAME[name].default


def plant_default(field: str) -> float:
    """Value of a field in the defaults of the plant's configuration."""
    return number(text("hil_tests/plant/src/config.rs"), rf"\b{field}: ([\d._]+),")


def test_wheels_and_track_are_those_of_the_vehicle() -> None:
    assert parameter("track") == round(VEHICLE.track_width * 1e6)
    count_pm = 2.0 * math.pi * VEHICLE.wheel_radius / VEHICLE.counts_per_revolution * 1e12
    for side in ("count_left", "count_right"):
        assert parameter(side) == round(count_pm)
    assert plant_default("track_width") == VEHICLE.track_width
    assert plant_default("wheel_radius") == VEHICLE.wheel_radius
    assert plant_default("counts_per_revolution") == VEHICLE.counts_per_revolution
    assert plant_default("footprint_radius") == VEHICLE.radius


def test_the_firmware_stops_what_the_companion_plans() -> None:
    """Its limits leave room above those that motion is planned with."""
    assert parameter("max_travel_velocity") > VEHICLE.travel.speed * 1e6
    assert parameter("max_travel_acceleration") > VEHICLE.travel.acceleration * 1e6
    assert parameter("max_heading_velocity") > VEHICLE.heading.speed * 1e6
    assert parameter("max_heading_acceleration") > VEHICLE.heading.acceleration * 1e6


def test_the_sonars_of_the_plant_are_mounted_where_the_vehicle_says() -> None:
    source = text("hil_tests/plant/src/config.rs")
    found = re.search(r"mounts: (\[\[.*\]\]),", source)
    assert found
    yaw = VEHICLE.sonars[0].yaw
    mounts = json.loads(found.group(1).replace("-yaw", str(-yaw)).replace("yaw", str(yaw)))
    for mount, sonar in zip(mounts, VEHICLE.sonars, strict=True):
        assert mount == pytest.approx([sonar.x, sonar.y, sonar.yaw])
        assert math.radians(number(source, r"half_angle: ([\d.]+)_f64")) == pytest.approx(sonar.half_angle)


def test_one_contact_patch_for_both_referees() -> None:
    found = re.search(r"const PATCH: \(f64, f64\) = \(([\d.]+), ([\d.]+)\);", text("hil_tests/plant/src/referee.rs"))
    assert found
    assert tuple(float(value) for value in found.groups()) == PATCH_M


def test_no_simulated_mine_is_larger_than_the_companion_keeps_off() -> None:
    assert SURFACE_MINE_RADII_M[0] < MINE_RADIUS_M < SURFACE_MINE_RADII_M[1] == KEPT_OFF_M


def test_the_field_leaves_room_around_the_zones_of_a_mission() -> None:
    mission = from_document({"area": {"width_m": 3.0, "height_m": 3.0}, "launch": {"x_m": 1.0, "y_m": 1.0}}, Path("m"))
    assert mission.detector.keepout_radius == MINE_KEEP_OUT_M


def test_one_baud_rate() -> None:
    assert pins_constant("BAUD") == DEFAULT_BAUD
    assert plant_default("baud") == DEFAULT_BAUD
    assert number(text("firmware/sitl/src/options.rs"), r"DEFAULT_BAUD: u32 = ([\d_]+);") == DEFAULT_BAUD
    assert number(text("protocol/python/examples/main.py"), r"BAUD = 0, ([\d_]+)") == DEFAULT_BAUD


def test_one_version_for_all_packages() -> None:
    for path in ("protocol/python", "companion", "hil_tests", "hil_tests/plant", "companion/native"):
        project = tomllib.loads(text(f"{path}/pyproject.toml"))["project"]
        assert project.get("version", rover.__version__) == rover.__version__, path
    for path in ("firmware/pico/Cargo.toml", "firmware/no_panic/Cargo.toml"):
        assert tomllib.loads(text(path))["package"]["version"] == rover.__version__, path
    assert tomllib.loads(text("Cargo.toml"))["workspace"]["package"]["version"] == rover.__version__
    assert f"\nversion: {rover.__version__}\n" in text("CITATION.cff")
    node = re.search(r"VERSION = \((\d+), (\d+), (\d+)\)", text("protocol/python/examples/node.py"))
    assert node
    assert ".".join(node.groups()) == rover.__version__
