"""The vehicle file, and that the standard rover's numbers are the same wherever tools force a second copy."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import rover
from hypothesis import given, settings
from hypothesis import strategies as st
from rover.errors import BadInput
from rover.link.baud import DEFAULT_BAUD
from rover.toml_file import read_toml
from rover.vehicle import STANDARD, Vehicle, load_vehicle
from rover.vehicle.file import TABLES, example
from rover.vehicle.firmware import KEYS, WIRING_KEYS, entries
from rover.vehicle.text import with_value
from rover_protocol.parameters import BY_NAME

ROOT = Path(__file__).resolve().parents[2]
PLANT = (ROOT / "hil_tests/plant/src/config.rs").read_text(encoding="utf-8")

WIDE = """
[body]
radius_m = 0.20
[wheels]
track_m = 0.28
radius_m = 0.04
counts_per_revolution = 2048
[travel]
speed_m_s = 0.3
[turning]
speed_rad_s = 0.9
"""


def read(folder: Path, text: str) -> Vehicle:
    file = folder / "vehicle.toml"
    file.write_text(text, encoding="utf-8")
    return load_vehicle(file)


def test_an_empty_file_is_the_standard_rover(tmp_path: Path) -> None:
    assert read(tmp_path, "") == STANDARD


def test_a_file_changes_what_it_names_and_nothing_else(tmp_path: Path) -> None:
    wide = read(tmp_path, WIDE)
    assert (wide.radius, wide.track_width, wide.wheel_radius, wide.counts_per_revolution) == (0.20, 0.28, 0.04, 2048)
    assert (wide.travel.speed, wide.travel.acceleration) == (0.3, STANDARD.travel.acceleration)
    assert (wide.heading.speed, wide.heading.jerk) == (0.9, STANDARD.heading.jerk)
    assert wide.sonars == STANDARD.sonars
    assert wide.wheel_reach == 0.16


def test_sonars_are_given_all_or_none(tmp_path: Path) -> None:
    mount = "[[sonar]]\nx_m = 0.1\ny_m = 0.0\nyaw_deg = 90\n"
    assert [sonar.yaw for sonar in read(tmp_path, 3 * mount).sonars] == [math.pi / 2] * 3
    with pytest.raises(BadInput, match=r"sonar: must be 3 tables \[\[sonar\]\]: left, centre and right, not 1"):
        read(tmp_path, mount)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("[wheels]\ntrack_cm = 20\n", r"\[wheels\] track_cm: unknown key; wrong unit\? it is track_m here"),
        ("[wheel]\ntrack_m = 0.2\n", r"wheel: unknown key; did you mean wheels\?"),
        ("[wheels]\ntrack_m = 20\n", r"\[wheels\] track_m: 20 lies outside 0.05 to 1 m"),
        ("[wheels]\ntrack_m = 0.3\n", r"\[body\] radius_m: the wheels reach 0.17 m .*disc of 0.15 m must hold them"),
        (
            "[travel]\nspeed_m_s = 0.49\n",
            r"0.61 m/s at the outer wheel, which reaches 0.45 m/s at full duty by \[drive\]",
        ),
        ("[travel]\nspeed_m_s = 0.3\n[turning]\nspeed_rad_s = 2.0\n", r"with 2 rad/s 0.3 m/s is 0.50 m/s"),
        ("[firmware]\nmax_travel_velocity = 200000\n", r"0.25 is planned with, .* max_travel_velocity, 0.2"),
        (
            "[firmware]\nstop_heading_acceleration = 1000000\nstop_heading_jerk = 2000000\n[turning]\nspeed_rad_s = 2\n"
            "[travel]\nspeed_m_s = 0.2\n",
            r"a stop from it takes 2.5 s, 2 at most",
        ),
        ("[firmware]\nsonar_slot = 25\n", r"\[firmware\] sonar_slot: 25 lies outside 30 to 500"),
        ("[firmware]\nsonar_slot = 60\n", r"guard_latency: with a sonar_slot of 60 ms a range is 210 ms old"),
        ("[firmware]\nguard_enabled = 0\n", r"guard_enabled: 0 is a value for the bench"),
        ("[firmware]\ndead_man = 5000\n", r"dead_man: 5000 is a value for the bench: .* 50 to 1000"),
        ("[firmware]\ntrack = 200000\n", r"\[firmware\] track: follows from \[wheels\] track_m; set it there"),
        ("[battery]\ncells = 4\nlow_v = 6.2\n", r"low_v: 6.2 V is 1.55 V for each of 4 cells"),
        ('[wiring]\nsonars = ["left", "left", "right"]\n', r"must name left, centre and right, each once"),
        ("[turning]\nspeed_rad_s = 'fast'\n", r"\[turning\] speed_rad_s: must be a number in rad/s, not 'fast'"),
    ],
)
def test_what_is_wrong_is_one_line(tmp_path: Path, text: str, says: str) -> None:
    with pytest.raises(BadInput, match=says):
        read(tmp_path, text)


def test_the_file_in_the_guide_is_the_example() -> None:
    guide = (ROOT / "docs/guide/operating.md").read_text(encoding="utf-8")
    (text,) = re.findall(r"```toml\n(# A rover, .*?)```", guide, re.DOTALL)
    assert text == example()


def parameter(name: str) -> int:
    """The default of a firmware parameter."""
    return BY_NAME[name].default


def plant(name: str) -> float:
    """A number of the plant's nominal rover."""
    found = re.search(rf"\b{name}: ([0-9_.]+),", PLANT)
    assert found is not None, name
    return float(found[1].replace("_", ""))


def test_the_firmwares_parameters_are_the_standard_rovers() -> None:
    assert parameter("track") == round(STANDARD.track_width * 1e6)
    for side in ("count_left", "count_right"):
        assert parameter(side) == round(STANDARD.metres_per_count * 1e12)


def test_the_standard_rover_asks_for_the_firmwares_defaults() -> None:
    assert {name: known.default for name, known in BY_NAME.items()} == STANDARD.parameters()


def test_the_example_is_the_standard_rover_with_every_key_that_there_is(tmp_path: Path) -> None:
    told = read(tmp_path, example())
    assert replace(told, camera="", baud=None) == STANDARD
    assert (told.camera, told.baud) == ("lepton-160", DEFAULT_BAUD)
    document = read_toml(tmp_path / "vehicle.toml")
    left_out = {"wheels": {"right_radius_m"}}
    for name, keys in {**TABLES, "wiring": WIRING_KEYS}.items():
        assert set(document[name]) == set(keys) - left_out.get(name, set()), name


@settings(max_examples=200, derandomize=True)
@given(st.data())
def test_what_a_board_holds_comes_back_through_the_file(tmp_path_factory: pytest.TempPathFactory, data: Any) -> None:
    """pull writes a board's value into the file, and the file asks for that value again."""
    known = BY_NAME[
        data.draw(st.sampled_from([*(key.parameter for key in KEYS), "wiring", "sonar_order", "count_left"]))
    ]
    near = {"feed_velocity": (1, 80_000), "count_left": (110_000_000, 150_000_000), "feed_static": (0, 3000)}
    value = data.draw(st.integers(*near.get(known.name, (known.minimum, known.maximum))))
    text = example()
    for entry in entries(known.name, value, STANDARD):
        text = with_value(text, *entry)
    asked = read(tmp_path_factory.mktemp("pull"), text).parameters()[known.name]
    assert abs(asked - value) <= (1 if known.name == "count_left" else 0)


def test_a_value_is_changed_in_its_place_and_nothing_else_of_the_file() -> None:
    before = example()
    after = with_value(before, "wheels", "track_m", "0.21")
    assert after == before.replace("track_m = 0.20 ", "track_m = 0.21 ")
    added = with_value(before, "firmware", "sonar_slot", "40")
    assert added == before + "sonar_slot = 40\n"
    assert with_value("", "wheels", "track_m", "0.21") == "[wheels]\ntrack_m = 0.21\n"


def test_the_firmware_allows_more_than_the_companion_asks_for() -> None:
    assert parameter("max_travel_velocity") * 1e-6 >= STANDARD.travel.speed
    assert parameter("max_travel_acceleration") * 1e-6 >= STANDARD.travel.acceleration
    assert parameter("max_heading_velocity") * 1e-6 >= STANDARD.heading.speed
    assert parameter("max_heading_acceleration") * 1e-6 >= STANDARD.heading.acceleration


def test_the_plants_nominal_rover_is_the_standard_one() -> None:
    assert plant("track_width") == STANDARD.track_width
    assert plant("wheel_radius") == STANDARD.wheel_radius
    assert plant("counts_per_revolution") == STANDARD.counts_per_revolution
    assert plant("footprint_radius") == STANDARD.radius
    assert plant("baud") == DEFAULT_BAUD


def test_board_and_companion_speak_at_one_rate() -> None:
    pins = (ROOT / "firmware/pico/src/pins.rs").read_text(encoding="utf-8")
    found = re.search(r"BAUD: u32 = ([0-9_]+);", pins)
    assert found is not None
    assert int(found[1].replace("_", "")) == DEFAULT_BAUD


PYPROJECTS = ("companion", "protocol/python", "hil_tests", "hil_tests/plant")
CRATES = ("Cargo.toml", "firmware/pico/Cargo.toml", "firmware/no_panic/Cargo.toml")


@pytest.mark.parametrize("folder", PYPROJECTS)
def test_every_python_package_has_the_companions_version(folder: str) -> None:
    project = read_toml(ROOT / folder / "pyproject.toml")["project"]
    assert project.get("version", rover.__version__) == rover.__version__
    assert "version" in project or "version" in project["dynamic"]


@pytest.mark.parametrize("file", CRATES)
def test_every_crate_has_the_companions_version(file: str) -> None:
    content = read_toml(ROOT / file)
    package = content.get("package") or content["workspace"]["package"]
    assert package["version"] == rover.__version__
