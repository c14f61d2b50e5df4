"""The mission file: what is right is read, and every mistake is one line that names file, section and key."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from rover.errors import BadInput, NoPath, RoverError
from rover.mission.config import SHIPPED, load
from rover.report.site import Georeference, GridPosition, Site

SMALL = """
[mission]
name = "small"
[area]
width_m = 3.0
height_m = 4.0
[launch]
x_m = 0.5
y_m = 0.5
"""

Write = Callable[[str], Path]


@pytest.fixture
def write(tmp_path: Path) -> Write:
    """Writes a mission file and returns its path."""

    def at(text: str) -> Path:
        file = tmp_path / "field.toml"
        file.write_text(text, encoding="utf-8")
        return file

    return at


def with_key(section: str, line: str, without: str = "") -> str:
    """SMALL with one more line in a section, and another line left out."""
    text = SMALL if f"[{section}]" in SMALL else f"{SMALL}[{section}]\n"
    lines = [kept for kept in text.splitlines() if not without or not kept.startswith(without)]
    lines.insert(lines.index(f"[{section}]") + 1, line)
    return "\n".join(lines) + "\n"


def refusal(file: Path, kind: type[RoverError] = BadInput) -> str:
    """The one line with which a file is refused; it begins with the file's name."""
    with pytest.raises(kind) as caught:
        load(file)
    text = str(caught.value)
    assert len(text.splitlines()) == 1
    assert text.startswith(f"{file}: ")
    return text.removeprefix(f"{file}: ")


def test_the_smallest_file_gets_the_documented_defaults(write: Write) -> None:
    mission = load(write(SMALL))
    assert (mission.name, mission.time_of_day_s, mission.max_duration_s) == ("small", 13 * 3600.0, 900.0)
    assert (mission.goals, mission.area.obstacles) == ((), ())
    assert (mission.launch.pose.heading, mission.launch.surveyed_radius) == (0.0, 0.25)
    assert (mission.rover.camera, mission.rover.cruise_speed, mission.rover.baud) == ("lepton-160", 0.25, 230_400)
    detector = mission.detector
    assert (detector.model, detector.report_threshold) == ("", 0.3)
    assert (detector.keepout_radius, detector.standoff) == (0.15, 0.45)
    field = mission.field
    assert (field.soil, field.rocks, field.grass, field.surface_mines) == ("loam", 5, 4, 2)
    assert field.buried_mine_depths == (0.01, 0.02, 0.05)


def test_a_field_of_two_strides_has_a_mine_to_find(write: Write) -> None:
    text = SMALL.replace("width_m = 3.0", "width_m = 1.5").replace("height_m = 4.0", "height_m = 1.5")
    field = load(write(text)).field
    assert (field.rocks, field.grass, field.surface_mines, field.buried_mine_depths) == (1, 1, 0, (0.01,))


def test_units_of_the_file_become_si(write: Write) -> None:
    text = with_key("launch", "heading_deg = 90")
    text = text.replace('name = "small"', 'time_of_day = "06:30"\ngoals = [[1, 2.5]]')
    mission = load(write(text + "[field]\nburied_mine_depths_cm = [3]\n"))
    assert mission.launch.pose.heading == pytest.approx(math.pi / 2)
    assert mission.time_of_day_s == 6.5 * 3600.0
    assert mission.goals == ((1.0, 2.5),)
    assert mission.field.buried_mine_depths == (0.03,)
    assert mission.name == "field"


def test_a_vehicle_file_changes_what_the_mission_allows(write: Write, tmp_path: Path) -> None:
    (tmp_path / "vehicle.toml").write_text("[body]\nradius_m = 0.3\n[travel]\nspeed_m_s = 0.2\n")
    text = with_key("rover", 'vehicle = "vehicle.toml"')
    mission = load(write(text))
    assert (mission.rover.vehicle.radius, mission.rover.vehicle.track_width) == (0.3, 0.20)
    assert (mission.rover.cruise_speed, mission.launch.surveyed_radius) == (0.2, 0.3)
    assert Path(mission.rover.vehicle_file) == tmp_path / "vehicle.toml"
    line = refusal(write(text.replace("x_m = 0.5", "x_m = 0.25")))
    assert line.startswith("[launch] x_m, y_m: (0.25, 0.5) is nearer than the rover's radius of 0.3 m")


def test_a_mistake_in_the_vehicle_file_is_told_with_both_files(write: Write, tmp_path: Path) -> None:
    (tmp_path / "vehicle.toml").write_text("[wheels]\ntrack_cm = 30\n")
    line = refusal(write(with_key("rover", 'vehicle = "vehicle.toml"')))
    assert line.startswith(f"[rover] vehicle: {tmp_path / 'vehicle.toml'}: [wheels] track_cm: unknown key; wrong unit?")


def test_a_site_has_names_and_a_place_on_earth(write: Write) -> None:
    assert load(write(SMALL)).site == Site()
    origin = "origin = [50.1, 8.7]\nbearing_deg = 30\n"
    site = load(write(SMALL + '[site]\nname = "meadow"\noperator = "N. N."\n' + origin)).site
    assert site == Site("meadow", "", "N. N.", Georeference(50.1, 8.7, 30.0))


@pytest.mark.parametrize(
    ("lines", "says"),
    [
        ("origin = [91, 8]", "[site] origin: latitude 91 lies outside -89 to 89 deg"),
        ("origin = [50, 181]", "[site] origin: 181 lies outside -180 to 180"),
        ("origin = [50]", "[site] origin: must be [latitude, longitude], not [50]"),
        ("bearing_deg = 30", "[site] bearing_deg: has no meaning without origin = [latitude, longitude], or epsg"),
        ('date = "4 May"', "[site] date: '4 May' is not a date like"),
        ("epsg = 4326\neasting = 1\nnorthing = 2", "[site] epsg: EPSG:4326 (WGS 84) is no projected system in metres"),
        ("epsg = 32633\neasting = 1e8\nnorthing = 2", "[site] epsg: 1e+08, 2 lies outside EPSG:32633"),
        ("origin = [50, 8]\nepsg = 32633", "[site] origin: has no meaning beside epsg"),
        ("orign = [50, 8]", "[site] orign: unknown key; did you mean origin?"),
    ],
)
def test_a_wrong_site_is_one_line(write: Write, lines: str, says: str) -> None:
    assert refusal(write(SMALL + "[site]\n" + lines + "\n")).startswith(says)


def test_a_site_may_be_placed_on_a_projected_grid(write: Write) -> None:
    # 3 degrees east of UTM zone 33's meridian at 60 degrees north the grid's north lies 3 sin(60°) to the east.
    grid = "epsg = 32633\neasting = 667294.821\nnorthing = 6655205.484\nbearing_deg = 10\n"
    site = load(write(SMALL + "[site]\n" + grid)).site
    assert site.origin is not None
    assert site.grid == GridPosition(32633, 667294.821, 6655205.484)
    assert (site.origin.latitude, site.origin.longitude) == pytest.approx((60.0, 18.0), abs=2e-6)
    assert site.origin.bearing_deg == pytest.approx(10.0 + 3.0 * math.sin(math.radians(60.0)), abs=0.01)


def test_a_mission_may_do_without_wheels_and_not_without_frames(write: Write) -> None:
    assert load(write(SMALL)).sources == ("wheels", "frames")
    assert load(write(with_key("localization", 'sources = ["frames"]'))).sources == ("frames",)
    for wrong in ('["wheels"]', "[]", '["frames", "gps"]', '"frames"'):
        assert "[localization] sources" in refusal(write(with_key("localization", f"sources = {wrong}")))


def test_the_shipped_demo_is_known_by_its_bare_name(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)
    assert load("demo") == load(SHIPPED / "demo.toml")
    assert load("demo").name == "demo"


def test_paths_are_relative_to_the_mission_file(write: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "mine.onnx").write_bytes(b"model")
    file = write(with_key("detector", 'model = "mine.onnx"'))
    monkeypatch.chdir("/")
    assert Path(load(file).detector.model) == tmp_path / "mine.onnx"


@pytest.mark.parametrize(
    ("section", "line", "without", "says"),
    [
        (
            "detector",
            "keepout_radius = 0.2",
            "",
            "[detector] keepout_radius: unknown key; did you mean keepout_radius_m?",
        ),
        ("mission", "gaols = [[1, 1]]", "", "[mission] gaols: unknown key; did you mean goals?"),
        ("area", "width_cm = 300", "width_m", "[area] width_cm: unknown key; wrong unit? it is width_m here"),
        ("launch", "heading_rad = 0.7", "", "[launch] heading_rad: unknown key; wrong unit? it is heading_deg here"),
        ("launch", "x_cm = 50", "x_m", "[launch] x_cm: unknown key; wrong unit? it is x_m here"),
        (
            "rover",
            "cruise_speed_cm = 25",
            "",
            "[rover] cruise_speed_cm: unknown key; wrong unit? it is cruise_speed_m_s here",
        ),
        (
            "mission",
            "max_duration_min = 5",
            "",
            "[mission] max_duration_min: unknown key; wrong unit? it is max_duration_s",
        ),
        ("field", "zzz = 1", "", "[field] zzz: unknown key; known are "),
    ],
)
def test_a_wrong_key_or_unit_is_named_with_the_right_one(
    write: Write, section: str, line: str, without: str, says: str
) -> None:
    assert refusal(write(with_key(section, line, without))).startswith(says)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (SMALL.replace("width_m = 3.0\n", ""), "[area] width_m: missing"),
        (SMALL.replace("height_m = 4.0\n", ""), "[area] height_m: missing"),
        (SMALL.replace("x_m = 0.5\n", ""), "[launch] x_m: missing"),
        (SMALL.replace("y_m = 0.5\n", ""), "[launch] y_m: missing"),
        (SMALL.replace("width_m = 3.0\n", "obstacles = []\n"), "[area] width_m: missing"),
        ("", "[area] width_m: missing"),
        (SMALL.partition("[launch]")[0], "[launch] x_m: missing"),
    ],
)
def test_a_missing_key_is_named_whatever_else_is_there(write: Write, text: str, says: str) -> None:
    assert refusal(write(text)) == says


def test_a_wrong_unit_is_named_wherever_in_its_section_it_stands(write: Write) -> None:
    file = write(SMALL.replace("width_m = 3.0\nheight_m = 4.0", "height_m = 4.0\nwidth_cm = 300"))
    assert refusal(file).startswith("[area] width_cm: unknown key; wrong unit? it is width_m")


@pytest.mark.parametrize(
    ("section", "line", "without", "names"),
    [
        ("area", 'width_m = "3.0"', "width_m", "[area] width_m: must be a number in m, not '3.0'"),
        ("area", "width_m = true", "width_m", "[area] width_m: must be a number in m, not True"),
        ("area", "width_m = nan", "width_m", "[area] width_m: nan"),
        ("area", "width_m = inf", "width_m", "[area] width_m: inf"),
        ("area", "width_m = -3.0", "width_m", "[area] width_m: -3.0 lies outside 1 to 100 m"),
        ("area", "width_m = 300", "width_m", "[area] width_m: 300 lies outside 1 to 100 m"),
        ("area", "width_m = 1" + 400 * "0", "width_m", "[area] width_m: "),
        ("area", "width_m = [3.0]", "width_m", "[area] width_m: must be a number"),
        ("area", "obstacles = [[1, 1]]", "", "[area] obstacles entry 1: must be [x, y, radius], not [1, 1]"),
        ("area", "obstacles = [1, 1, 0.2]", "", "[area] obstacles entry 1: must be [x, y, radius], not 1"),
        ("area", "obstacles = 3", "", "[area] obstacles: must be a list of [x, y, radius]"),
        ("area", "obstacles = [[2, 2, 0.2], [1, nan, 0.1]]", "", "[area] obstacles entry 2: nan"),
        ("area", "obstacles = [[2, 2, 0]]", "", "[area] obstacles: radius 0 of (2, 2) must be above 0"),
        ("area", "obstacles = [[2, 2, -0.1]]", "", "[area] obstacles: radius -0.1 of (2, 2) must be above 0"),
        ("mission", 'time_of_day = "25:00"', "", "[mission] time_of_day: '25:00' is not a time of day"),
        ("mission", 'time_of_day = "13:60"', "", "[mission] time_of_day: '13:60'"),
        ("mission", 'time_of_day = "13"', "", "[mission] time_of_day: '13'"),
        ("mission", 'time_of_day = "²:00"', "", "[mission] time_of_day: '²:00'"),
        ("mission", "time_of_day = 13", "", "[mission] time_of_day: must be a string in quotes, not 13"),
        ("mission", "time_of_day = 13:00:00", "", "[mission] time_of_day: must be a string"),
        ("mission", "goals = [[1, 1], [9, 9]]", "", "[mission] goals entry 2: (9, 9) lies outside the 3 x 4 m area"),
        ("mission", "goals = [[nan, 1]]", "", "[mission] goals entry 1: nan"),
        ("mission", "max_duration_s = 0", "", "[mission] max_duration_s: 0 lies outside"),
        ("launch", "x_m = 0.1", "x_m", "[launch] x_m, y_m: (0.1, 0.5) is nearer than the rover's radius"),
        ("launch", "y_m = 5.0", "y_m", "[launch] x_m, y_m: (0.5, 5) is nearer"),
        ("launch", "surveyed_radius_m = 0.1", "", "[launch] surveyed_radius_m: 0.1 lies outside 0.15"),
        ("rover", 'camera = "away.toml"', "", "[rover] camera: "),
        ("rover", 'camera = "lepton-161"', "", "[rover] camera: "),
        ("rover", "cruise_speed_m_s = 2", "", "[rover] cruise_speed_m_s: 2 lies outside 0.05 to 0.25 m/s"),
        ("rover", "baud = 9600.0", "", "[rover] baud: must be a whole number, not 9600.0"),
        ("detector", 'model = "away.onnx"', "", "[detector] model: "),
        ("detector", 'model = "."', "", "[detector] model: "),
        ("detector", 'model = "a\\u0000b"', "", "[detector] model: "),
        ("detector", "report_threshold = 1.5", "", "[detector] report_threshold: 1.5 lies outside"),
        ("field", 'soil = "moon"', "", "[field] soil: 'moon' is not one of dry-sand, loam"),
        ("field", "rocks = -1", "", "[field] rocks: -1 lies outside"),
        ("field", "rocks = 1.5", "", "[field] rocks: must be a whole number, not 1.5"),
        ("field", "buried_mine_depths_cm = 3", "", "[field] buried_mine_depths_cm: must be a list of numbers, not 3"),
        (
            "field",
            "buried_mine_depths_cm = [0.01]",
            "",
            "[field] buried_mine_depths_cm: 0.01 lies outside 0.5 to 15 cm",
        ),
    ],
)
def test_a_wrong_value_is_one_line_with_section_and_key(
    write: Write, section: str, line: str, without: str, names: str
) -> None:
    assert refusal(write(with_key(section, line, without))).startswith(names)


@pytest.mark.parametrize("key", ["model", "camera"])
def test_a_missing_file_is_named_as_it_was_looked_for(write: Write, tmp_path: Path, key: str) -> None:
    section = {"model": "detector", "camera": "rover"}[key]
    line = refusal(write(with_key(section, f'{key} = "away/this.toml"')))
    assert line == f"[{section}] {key}: {tmp_path / 'away' / 'this.toml'}: no such file"


def test_a_goal_inside_a_known_obstacle_has_no_path(write: Write) -> None:
    text = with_key("area", "obstacles = [[2, 2, 0.3]]").replace('name = "small"', "goals = [[1, 1], [2.1, 2.1]]")
    line = refusal(write(text), NoPath)
    assert line.startswith("[mission] goals entry 2: (2.1, 2.1) lies inside the obstacle at (2, 2), r 0.3 m")


def test_a_launch_that_touches_a_known_obstacle_has_no_path(write: Write) -> None:
    touching, clear = (with_key("area", f"obstacles = [[{x}, 0.5, 0.2]]") for x in (0.84, 0.86))
    assert refusal(write(touching), NoPath).startswith("[launch]: the rover would stand in the obstacle at (0.84, 0.5)")
    assert load(write(clear)).area.obstacles == ((0.86, 0.5, 0.2),)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (SMALL + "[filed]\nrocks = 1\n", "filed: unknown key; did you mean field?"),
        ("rocks = 3\n" + SMALL, "rocks: unknown key; known are mission, site, area"),
        (SMALL.replace("[launch]", "[[launch]]"), "[launch] must be a table"),
        ("area = 3\n", "[area] must be a table"),
        (SMALL + '["a\\nb"]\nx = 1\n', "a\\nb: unknown key"),
        (with_key("area", '"a\\nb" = 1'), "[area] "),
    ],
)
def test_a_wrong_section_is_named(write: Write, text: str, says: str) -> None:
    assert refusal(write(text)).startswith(says)


@pytest.mark.parametrize("text", ["this is no TOML", SMALL + "x_m = 1\nx_m = 2\n", "[area\n", "a = " + 5000 * "["])
def test_what_is_not_toml_is_said_to_be_none(write: Write, text: str) -> None:
    assert refusal(write(text)).startswith("not valid TOML: ")


def test_binary_a_folder_and_nothing_at_all_are_refused(tmp_path: Path) -> None:
    binary = tmp_path / "picture.toml"
    binary.write_bytes(bytes(range(256)))
    assert refusal(binary).startswith("not valid TOML")
    assert refusal(tmp_path).startswith("is a folder")
    assert refusal(tmp_path / "away.toml") == "no such file"
    assert refusal(binary / "under-a-file.toml")
    assert refusal(tmp_path / (300 * "x"))


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.one_of(st.text(), st.text("[]=\"'.,#\n 01emx_-n")))
def test_no_text_at_all_gives_anything_but_a_mission_or_one_clear_line(tmp_path: Path, text: str) -> None:
    file = tmp_path / "field.toml"
    file.write_bytes(text.encode("utf-8", "surrogatepass"))
    refusal(file)


VALUES = st.one_of(
    st.integers(-(2**70), 2**70).map(str),
    st.sampled_from(["nan", "-inf", "1e999", "true", "1979-05-27", "07:32:00", "{}", "{a = 1}", "'x'", "''", "1e-320"]),
    st.floats(-10, 10, allow_nan=False).map(repr),
    st.lists(st.sampled_from(["1", "[]", "[1, 2]", "[1, 2, 3]", "'x'", "{}", "nan"]), max_size=3).map(
        lambda items: "[" + ", ".join(items) + "]"
    ),
    st.text("0123456789:²٣ ", max_size=6).map(lambda text: f"'{text}'"),
)
KEYS = st.sampled_from(
    [
        "mission.name",
        "mission.time_of_day",
        "mission.max_duration_s",
        "mission.goals",
        "area.obstacles",
        "launch.heading_deg",
        "launch.surveyed_radius_m",
        "rover.camera",
        "rover.cruise_speed_m_s",
        "rover.baud",
        "detector.model",
        "detector.standoff_m",
        "field.soil",
        "field.rocks",
        "field.grass",
        "field.surface_mines",
        "field.buried_mine_depths_cm",
    ]
)


@settings(max_examples=300, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(KEYS, VALUES)
def test_any_value_for_any_key_is_taken_or_refused_by_that_key(tmp_path: Path, key: str, value: str) -> None:
    section, name = key.split(".")
    text = with_key(section, f"{name} = {value}", without=f"{name} ")
    file = tmp_path / "field.toml"
    file.write_text(text, encoding="utf-8")
    try:
        load(file)
    except RoverError as refused:
        line = str(refused)
        assert line.startswith(f"{file}: [")
        # A huge obstacle is refused at the launch or goal that lies in it: that line speaks of the obstacle.
        assert f"[{section}] {name}" in line or (name == "obstacles" and "in the obstacle at" in line)
        assert len(line.splitlines()) == 1
