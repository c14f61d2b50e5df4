"""A mission whose time ran out, and the next one that goes on with what it has learned, from where the rover stands."""

from __future__ import annotations

import json
import math
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rover.archive_file import read_archive, write_archive
from rover.errors import PreflightFailed
from rover.record.tum import read_tum
from rover_hil.firmware_process import find_binary

pytestmark = pytest.mark.rig("sitl")

MISSION = """
[mission]
name = "cut"
time_of_day = "13:00"
max_duration_s = {seconds}

[area]
width_m = {width}
height_m = 1.6

[launch]
x_m = 0.45
y_m = 0.45
heading_deg = 45.0

[field]
soil = "loam"
rocks = 1
grass = 0
surface_mines = 1
buried_mine_depths_cm = [1.0]
"""


def rover(*words: object) -> subprocess.CompletedProcess[str]:
    command = [str(Path(sys.executable).with_name("rover")), *map(str, words)]
    return subprocess.run(command, capture_output=True, text=True, timeout=150.0)


def summary(folder: Path) -> dict[str, Any]:
    document: dict[str, Any] = json.loads((folder / "summary.json").read_text())
    return document


@pytest.fixture(scope="module")
def mission(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Path]:
    """A mission file with that time limit and width."""
    folder = tmp_path_factory.mktemp("missions")

    def write(seconds: float, width: float = 2.2) -> Path:
        file = folder / f"cut-{seconds:g}-{width:g}.toml"
        file.write_text(MISSION.format(seconds=seconds, width=width))
        return file

    return write


@pytest.fixture(scope="module")
def first(mission: Callable[..., Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a run that was cut short by its time limit."""
    try:
        find_binary()
    except PreflightFailed as missing:
        pytest.skip(str(missing))
    out = tmp_path_factory.mktemp("first")
    ended = rover("run", mission(16.0), "--seed", 3, "--out", out, "--quiet")
    assert ended.returncode == 8, ended.stderr
    return out


@pytest.fixture(scope="module")
def second(mission: Callable[..., Path], first: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the run that went on from there."""
    out = tmp_path_factory.mktemp("second")
    ended = rover("run", mission(120.0), "--seed", 3, "--resume", first, "--out", out, "--quiet")
    assert ended.returncode == 0, ended.stderr
    return out


def test_it_ends_what_the_first_had_begun(first: Path, second: Path) -> None:
    before, after = (json.loads((folder / "truth.json").read_text())["verdict"] for folder in (first, second))
    assert before["seen_share"] < 0.85 < after["seen_share"]
    assert after["mines_with_contrast_found"] == after["mines_with_contrast"] > 0
    assert summary(second)["duration_s"] < 100.0


def test_it_begins_where_the_rover_stands_and_finds_that_out_by_itself(first: Path, second: Path) -> None:
    stood, stands = read_tum(first / "truth.tum")[-1, 1:], read_tum(second / "truth.tum")[0, 1:]
    np.testing.assert_allclose(stands, stood, atol=1e-5)
    believed = read_tum(second / "trajectory.tum")[0, 1:]
    assert np.hypot(*(believed[:2] - stands[:2])) < 0.03
    assert summary(second)["localization"]["ate_rmse_m"] < 0.02


def test_no_wheel_goes_where_none_may_be_with_what_either_run_has_seen(second: Path) -> None:
    ended = summary(second)
    assert (ended["collisions"], ended["keepout_violations"]) == (0, 0)
    assert ended["unseen_ground_m2"] == 0.0


def test_indications_keep_their_numbers_and_are_not_told_twice(first: Path, second: Path) -> None:
    before = {d["id"]: (d["x"], d["y"]) for d in summary(first)["detections"]}
    after = {d["id"]: (d["x"], d["y"]) for d in summary(second)["detections"]}
    assert before
    for number, place in before.items():
        assert np.hypot(*np.subtract(after[number], place)) < 0.03
    places = list(after.values())
    assert all(np.hypot(*np.subtract(a, b)) > 0.2 for i, a in enumerate(places) for b in places[:i])


def test_its_log_alone_is_enough_for_a_replay(second: Path, tmp_path: Path) -> None:
    log = shutil.copy(second / "mission.mcap", tmp_path)
    ended = rover("replay", log, "--json", "--quiet")
    assert json.loads(ended.stdout)["identical"], ended.stdout


def test_its_own_knowledge_is_left_for_a_third(second: Path) -> None:
    survey = read_archive(second / "survey.npz", "survey")
    seen_m2 = sum(layer.sum() for name, layer in survey.items() if name.endswith("_seen")) * 0.02**2
    assert seen_m2 > 0.6 * summary(second)["area_m2"]


def damage(folder: Path) -> None:
    file = folder / "survey.npz"
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])


def lose_a_place(folder: Path) -> None:
    """A place whose x is no number would be lost to every comparison, and a known mine with it."""
    arrays = read_archive(folder / "survey.npz", "survey")
    content = json.loads(arrays["content"].tobytes())
    content["places"][0]["x"] = math.nan
    arrays["content"] = np.frombuffer(json.dumps(content).encode(), np.uint8)
    write_archive(folder / "survey.npz", "survey", arrays)


@pytest.mark.parametrize(
    ("seed", "width", "spoil", "told"),
    [
        (3, 2.2, lose_a_place, "survey.npz: damaged, or no survey"),
        (3, 2.2, damage, "survey.npz: damaged, or no survey"),
        (3, 2.2, lambda folder: (folder / "survey.npz").unlink(), "survey.npz: no such survey"),
        (3, 2.2, lambda folder: (folder / "keyframes.npz").unlink(), "keyframes.npz: no such keyframe map"),
        (3, 2.2, lambda folder: (folder / "truth.json").unlink(), "truth.json: not there, or damaged"),
        (4, 2.2, lambda folder: None, "driven with --seed 3, a field other than that of --seed 4"),
        (3, 2.4, lambda folder: None, "of an area of 2.2 × 1.6 m"),
    ],
)
def test_what_does_not_fit_is_told_in_one_line(
    mission: Callable[..., Path],
    first: Path,
    tmp_path: Path,
    seed: int,
    width: float,
    spoil: Callable[[Path], None],
    told: str,
) -> None:
    spoiled = shutil.copytree(first, tmp_path / "spoiled")
    spoil(spoiled)
    out = tmp_path / "out"
    ended = rover("run", mission(20.0, width), "--seed", seed, "--resume", spoiled, "--out", out, "--quiet")
    assert ended.returncode == 2
    assert told in ended.stderr
    assert len(ended.stderr.strip().splitlines()) == 1


def test_a_run_is_not_written_over_the_one_that_it_goes_on_from(mission: Callable[..., Path], first: Path) -> None:
    ended = rover("run", mission(20.0), "--seed", 3, "--resume", first, "--out", first, "--force", "--quiet")
    assert (ended.returncode, (first / "mission.mcap").exists()) == (2, True)
    assert "name another folder" in ended.stderr
