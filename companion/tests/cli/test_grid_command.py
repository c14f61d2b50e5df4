"""`rover grid`: pictures to a map that `rover plan` reads (figure 5 of the paper)."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from rover.mapping import map_server

ROWS, COLUMNS = 120, 160
STONE = np.s_[20:32, 100:112]


def thermal(path: Path, kelvin: float = 300.0) -> Path:
    picture = kelvin + np.random.default_rng(1).normal(0.0, 0.05, (ROWS, COLUMNS))
    picture[STONE] += 6.0
    cv2.imwrite(str(path), np.round(100.0 * picture).astype(np.uint16))
    return path


def photograph(path: Path) -> Path:
    picture = 100.0 + np.random.default_rng(2).normal(0.0, 3.0, (ROWS, COLUMNS, 3))
    picture[STONE] = 200.0
    cv2.imwrite(str(path), np.clip(picture, 0, 255).astype(np.uint8))
    return path


def expected() -> NDArray[np.bool_]:
    stone = np.zeros((ROWS, COLUMNS), bool)
    stone[STONE] = True
    return np.flipud(stone)


def test_a_thermal_picture_gives_a_map_with_the_stone_where_it_lies(rover, tmp_path):
    out = tmp_path / "ground.yaml"
    result = rover("grid", str(thermal(tmp_path / "a.tif")), "--metres-per-pixel", "0.02", "--out", str(out), "--json")
    found = json.loads(result.out)
    stored = map_server.read(out)
    assert (result.code, found["out"], stored.resolution) == (0, str(out), 0.02)
    assert (stored.occupied == expected()).all()
    assert (found["occupied"], found["free"]) == (expected().sum(), (~expected()).sum())


def test_a_photograph_gives_the_same_by_its_lightness(rover, tmp_path):
    out = tmp_path / "photo.yaml"
    result = rover("grid", str(photograph(tmp_path / "a.png")), "--visible", "--out", str(out))
    assert result.code == 0
    agreed = map_server.read(out).occupied == expected()
    assert agreed.mean() > 0.995


def test_the_map_is_one_that_plan_reads(rover, tmp_path):
    out = tmp_path / "ground.yaml"
    rover("grid", str(thermal(tmp_path / "a.tif")), "--out", str(out))
    plan = rover("plan", "--map", str(out), "--start", "0.3,0.6", "--goal", "1.4,0.6", "--algorithm", "rrt-star",
                 "--robot-radius", "0.05", "--json")  # fmt: skip
    assert (plan.code, json.loads(plan.out)["status"]) == (0, "ok")


def test_what_one_picture_of_several_shows_is_outvoted(rover, tmp_path):
    out = tmp_path / "ground.yaml"
    with_stone = thermal(tmp_path / "a.tif")
    bare = np.round(100.0 * (300.0 + np.random.default_rng(3).normal(0.0, 0.05, (ROWS, COLUMNS)))).astype(np.uint16)
    cv2.imwrite(str(tmp_path / "b.tif"), bare)
    rover("grid", str(with_stone), str(tmp_path / "b.tif"), str(tmp_path / "b.tif"), "--out", str(out))
    assert not map_server.read(out).occupied.any()


def test_a_mounted_camera_lays_the_ground_out_ahead(rover, tmp_path):
    out = tmp_path / "ahead.yaml"
    result = rover("grid", str(thermal(tmp_path / "a.tif")), "--camera", "lepton-160", "--out", str(out), "--json")
    found, stored = json.loads(result.out), map_server.read(out)
    rows, columns = np.nonzero(stored.occupied)
    assert found["occupied"] == len(rows) > 0
    # The stone is high up and to the right in the picture: far ahead, and on the right, where y is low.
    assert columns.mean() > 0.6 * found["width"]
    assert rows.mean() < 0.5 * found["height"]


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        (("--visible",), "a.tif: a 16-bit picture: leave out --visible"),
        (("--metres-per-pixel", "2"), "--metres-per-pixel 2: "),
        (("--metres-per-pixel", "0.1", "--camera", "lepton-160"), "only one of them can tell the scale"),
    ],
)
def test_what_does_not_fit_is_one_line(rover, tmp_path, options, complaint):
    result = rover("grid", str(thermal(tmp_path / "a.tif")), *options, "--out", str(tmp_path / "map.yaml"))
    assert (result.code, result.out) == (2, "")
    assert complaint in result.err
    assert len(result.err.strip().splitlines()) == 1


def test_pictures_of_different_sizes_are_refused_by_name(rover, tmp_path):
    cv2.imwrite(str(tmp_path / "b.tif"), np.full((60, 80), 30_000, np.uint16))
    result = rover("grid", str(thermal(tmp_path / "a.tif")), str(tmp_path / "b.tif"), "--out", str(tmp_path / "m.yaml"))
    assert result.code == 2
    assert "b.tif: picture of 80x60 pixels" in result.err
