"""`rover plan` on maps that others made and that once were read wrongly: a plan, or one line with the true reason."""

from __future__ import annotations

import io
import json
import math
import os
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from rover.mapping import map_server
from rover.planning.planner import ALGORITHMS

HEAD = "image: map.{}\nresolution: 0.1\n"
SHADES = np.full((20, 30), 254, np.uint8)
SHADES[8:12, 10:30] = 0
SHADES[0:4, 0:4] = 205


def write(folder: Path, rest: str, kind: str = "pgm", content: bytes | None = None) -> Path:
    """A map of 3 × 2 m whose wall leaves a passage of 1 m at the left; grey at the upper left."""
    buffer = io.BytesIO()
    Image.fromarray(SHADES).save(buffer, {"pgm": "PPM", "jpg": "JPEG", "png": "PNG"}[kind])
    (folder / f"map.{kind}").write_bytes(buffer.getvalue() if content is None else content)
    (folder / "map.yaml").write_text(HEAD.format(kind) + rest, encoding="utf-8")
    return folder / "map.yaml"


def ask(rover, file, *more):
    return rover("plan", "--map", file, "--start", "2.5,1.6", "--goal", "2.5,0.4", "--robot-radius", "0.1", *more)


def refused(result, reason):
    """Whether the command ended with one line that has the reason."""
    assert (result.code, result.out) == (2, "")
    assert result.err.startswith("rover: ")
    assert result.err.count("\n") == 1
    assert reason in result.err


@pytest.mark.parametrize(
    "rest",
    [
        "origin:\n  - 0\n  - 0\n  - 0\n",
        "origin: [0,\n  0,\n  0,\n]\n",
        "origin: [0, 0, 1e-6]\nnegate: FALSE\nmode: Trinary\n",
        "origin: [0.0, -0.0, -1.0e-06] # 'not' turned\nnegate: Off\n",
    ],
)
def test_a_map_in_any_style_leads_around_its_wall(rover, tmp_path, rest):
    result = ask(rover, write(tmp_path, rest), "--json")
    assert (result.code, result.err) == (0, "")
    assert json.loads(result.out)["length_m"] > 2.0 * math.hypot(1.5, 0.4)


@pytest.mark.parametrize(
    ("rest", "reason"),
    [
        ("origin: [0, 0, -nan]\n", "map.yaml: origin: finite numbers are expected, got -nan"),
        ("origin: [0, 0, .NaN]\n", "map.yaml: origin: finite numbers are expected, got nan"),
        ("origin:\n- 0\n- 0\n- 1.5707963\n", "the map is turned by 1.5708 rad"),
        ("origin: [0, 0, -0.02]\n", "the map is turned by -0.02 rad"),
        ("origin: [0, 0, 0]\nmode: scale\nfree_thresh: 0.0\noccupied_thresh: 1.0\n", "a mask of speeds or costs"),
    ],
)
def test_a_map_that_cannot_be_read_is_refused_for_its_own_reason(rover, tmp_path, rest, reason):
    refused(ask(rover, write(tmp_path, rest)), reason)


@pytest.mark.parametrize("kind", ["jpg", "png", "pgm"])
@pytest.mark.parametrize("kept", [0.5, 0.8, 0.98])
def test_a_picture_that_ends_early_is_cut(rover, tmp_path, kind, kept):
    whole = write(tmp_path, "origin: [0, 0, 0]\n", kind).with_name(f"map.{kind}").read_bytes()
    file = write(tmp_path, "origin: [0, 0, 0]\n", kind, whole[: int(kept * len(whole))])
    refused(ask(rover, file), f"rover: {tmp_path / f'map.{kind}'}: the picture is cut\n")


def test_a_wall_stays_a_wall_whatever_the_maximum_of_its_picture(rover, tmp_path):
    lengths = set()
    for maximum in (15, 100, 255, 4095):
        values = np.rint(SHADES / 254.0 * maximum).astype(">u2" if maximum > 255 else "u1")
        content = f"P5\n30 20\n{maximum}\n".encode() + values.tobytes()
        result = ask(rover, write(tmp_path, "origin: [0, 0, 0]\n", "pgm", content), "--json")
        lengths.add(round(json.loads(result.out)["length_m"], 9))
    assert len(lengths) == 1
    assert lengths.pop() > 2.5


def test_transparent_ground_is_blocked_unless_unknown_ground_is_free(rover, tmp_path):
    layers = np.dstack([np.full((20, 30), 255, np.uint8)] * 4)
    layers[8:12, 10:30, 3] = 0
    buffer = io.BytesIO()
    Image.fromarray(layers).save(buffer, "PNG")
    file = write(tmp_path, "origin: [0, 0, 0]\n", "png", buffer.getvalue())
    around, through = ask(rover, file, "--json"), ask(rover, file, "--unknown", "free", "--json")
    assert json.loads(around.out)["length_m"] > 2.5
    assert json.loads(through.out)["length_m"] == pytest.approx(1.2)
    assert "80 cells look unknown and count as free" in through.err


def test_the_saver_s_grey_is_blocked_with_one_line_that_counts_it(rover, tmp_path):
    file = write(tmp_path, "origin: [0, 0, 0]\nfree_thresh: 0.25\noccupied_thresh: 0.65\n")
    result = ask(rover, file)
    assert result.code == 0
    assert result.err.count("\n") == 1
    assert "16 cells have the grey of unknown ground (205) and count as blocked" in result.err
    assert "16 cells look unknown and count as free" in ask(rover, file, "--unknown", "free").err


def clearance(path, blocked):
    """Least distance of a path from blocked squares of side 1, by brute force, for 200 points a leg."""
    corners = np.asarray(path)
    along = np.linspace(0.0, 1.0, 200)[:, None, None]
    points = (corners[:-1] + along * (corners[1:] - corners[:-1])).reshape(-1, 1, 2)
    low = np.argwhere(blocked)[:, ::-1]
    gap = np.maximum(np.maximum(low - points, points - low - 1.0), 0.0)
    return np.hypot(gap[..., 0], gap[..., 1]).min()


def movingai(file):
    rows = file.read_text().splitlines()[4:]
    return np.array([list(row) for row in rows]) != "."


@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize("radius", [0.0, 0.3])
def test_no_plan_cuts_a_corner_or_slips_between_two_that_touch(rover, tmp_path, algorithm, radius):
    file = tmp_path / "slant.map"
    rows = [".......", "...@...", "..@....", ".@.....", "....@..", ".....@.", "......."]
    file.write_text("type octile\nheight 7\nwidth 7\nmap\n" + "\n".join(rows) + "\n")
    choice = ("--algorithm", algorithm, "--robot-radius", radius, "--json")
    for start, goal in (("0.5,0.5", "6.5,6.5"), ("1.5,1.5", "3.5,3.5"), ("5.5,3.5", "3.5,5.5")):
        result = rover("plan", "--map", file, "--start", start, "--goal", goal, *choice)
        assert result.code == 0
        assert clearance(json.loads(result.out)["path"], movingai(file)) >= radius - 1e-9
    closed = [row[:x] + "@" + row[x + 1 :] for x, row in zip((6, 5, 4, 3, 2, 1, 0), rows, strict=True)]
    file.write_text("type octile\nheight 7\nwidth 7\nmap\n" + "\n".join(closed) + "\n")
    assert rover("plan", "--map", file, "--start", "0.5,0.5", "--goal", "6.5,6.5", *choice).code == 4


@pytest.fixture
def cases():
    folder = Path(os.environ.get("ROVER_DATA", "")) / "cases"
    if not os.environ.get("ROVER_DATA") or not folder.is_dir():
        pytest.skip("ROVER_DATA does not lead to cases/: the maps of others are not part of the project")
    return folder


@pytest.mark.parametrize(
    "name",
    ["block_origin", "bom", "flow_multi", "hash_quoted", "mode_caps", "negate_false", "negate_true", "origin_trailing"],
)
def test_shared_maps_are_read_in_every_style(rover, cases, name):
    file = cases / "05_yaml_subset" / f"{name}.yaml"
    stored = map_server.read(file)
    shades = np.asarray(Image.open(cases / "05_yaml_subset" / "m.pgm"))[::-1]
    assert stored.resolution == 0.05
    assert stored.origin == (0.0, 0.0)
    assert np.array_equal(stored.occupied, shades == (254 if name == "negate_true" else 0))
    place = np.argwhere(stored.seen & ~stored.occupied)[0]
    point = "{:.3f},{:.3f}".format(*(0.05 * (place[::-1] + 0.5)))
    result = rover("plan", "--map", file, "--start", point, "--goal", point, "--robot-radius", "0")
    assert (result.code, result.err) == (0, "")


@pytest.mark.parametrize(
    ("file", "reason"),
    [
        ("06_origin_nan/origin_nan.yaml", "origin_nan.yaml: origin: finite numbers are expected, got -nan"),
        ("06_origin_nan/origin_nan2.yaml", "origin_nan2.yaml: origin: finite numbers are expected, got nan"),
        ("16_octile_corner_all_blocked/maps_wc3maps_adrenaline.map", "a map of type octile-corner can't be read"),
        ("20_truncated_jpeg_map/jpg_short.yaml", "short.jpg: the picture is cut"),
        ("32_plans/yaw.yaml", "yaw.yaml: origin: the map is turned by 0.5 rad; only maps with yaw 0 can be read"),
    ],
)
def test_shared_maps_that_cannot_be_read_are_refused_for_the_true_reason(rover, cases, file, reason):
    refused(ask(rover, cases / file), reason)


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_shared_gaps_between_corners_are_closed(rover, cases, algorithm):
    file = cases / "32_plans" / "diag.map"
    for radius in (0.0, 0.3):
        choice = ("--robot-radius", radius, "--algorithm", algorithm, "--json")
        result = rover("plan", "--map", file, "--start", "0.5,5.5", "--goal", "5.5,0.5", *choice)
        assert result.code == 0
        assert clearance(json.loads(result.out)["path"], movingai(file)) >= radius - 1e-9


@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize(
    ("start", "goal", "reason"),
    [
        ("2,1.5", "2,2.5", "the start (2, 1.5) is -0.200 m from the nearest obstacle or wall; the robot needs 0.15 m"),
        ("2,0.5", "2,1.5", "goal 1 (2, 1.5): nearer than 0.15 m to an obstacle or wall"),
        ("0.05,0.05", "2,2.5", "the start (0.05, 0.05) is 0.050 m from the nearest obstacle or wall"),
    ],
)
def test_a_shared_field_says_what_stands_in_an_obstacle(rover, cases, algorithm, start, goal, reason):
    file = cases / "32_plans" / "paper.toml"
    result = rover("plan", "--map", file, "--start", start, "--goal", goal, "--algorithm", algorithm)
    assert (result.code, result.out, result.err.count("\n")) == (4, "", 1)
    assert f"no path: {reason}" in result.err
