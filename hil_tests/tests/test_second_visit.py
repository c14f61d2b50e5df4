"""A field surveyed twice, in the morning and in the afternoon: the second run fuses both, and drops nothing."""

from __future__ import annotations

import json
import math
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from rover.errors import PreflightFailed
from rover_hil.firmware_process import find_binary

pytestmark = [pytest.mark.rig("sitl"), pytest.mark.slow]

SMALL = Path(__file__).resolve().parent / "missions" / "small.toml"
HOURS = ("09:30", "15:30")


def rover(*words: object) -> subprocess.CompletedProcess[str]:
    command = [str(Path(sys.executable).with_name("rover")), *map(str, words)]
    return subprocess.run(command, capture_output=True, text=True, timeout=900.0, check=False)


@pytest.fixture(scope="module")
def visits(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """The folders of both runs."""
    try:
        find_binary()
    except PreflightFailed as missing:
        pytest.skip(str(missing))
    folder = tmp_path_factory.mktemp("visits")
    after: list[object] = []
    for number, hour in enumerate(HOURS):
        mission = folder / f"{number}.toml"
        mission.write_text(SMALL.read_text().replace("13:00", hour))
        out = folder / f"run-{number}"
        ended = rover("run", mission, "--seed", 11, "--out", out, "--quiet", *after)
        assert ended.returncode == 0, ended.stderr
        after = ["--after", out]
    return folder / "run-0", folder / "run-1"


def summary(folder: Path) -> dict[str, Any]:
    document: dict[str, Any] = json.loads((folder / "summary.json").read_text())
    return document


def test_every_place_that_the_first_visit_reported_keeps_its_number_and_its_place(visits: tuple[Path, Path]) -> None:
    first, second = map(summary, visits)
    there = {entry["id"]: entry for entry in second["detections"]}
    assert first["detections"]
    for entry in first["detections"]:
        kept = there[entry["id"]]
        assert math.dist((kept["x"], kept["y"]), (entry["x"], entry["y"])) < 0.1
        assert kept["p"] >= entry["p"] - 0.01
    assert second["wheel_over_mine"] == second["keepout_violations"] == second["collisions"] == 0


def test_both_maps_lie_on_each_other_and_each_place_says_what_each_visit_found(visits: tuple[Path, Path]) -> None:
    told = summary(visits[1])["visits"]
    assert told["after"] == visits[0].name
    assert told["hours"] == [9.5, 15.5]
    assert math.hypot(told["shift"]["x"], told["shift"]["y"]) < 0.06
    assert told["agreement"] > 0.3
    reported = {entry["id"] for entry in summary(visits[0])["detections"]}
    assert {place["id"] for place in told["places"] if place["first_p"] is not None} == reported
    report = (visits[1] / "report.html").read_text()
    assert "Two visits" in report
    assert report.count("<figcaption>") == 3


def test_the_log_of_a_second_visit_replays(visits: tuple[Path, Path]) -> None:
    replayed = rover("replay", visits[1] / "mission.mcap", "--rig", "sitl", "--json")
    assert json.loads(replayed.stdout)["identical"], replayed.stdout


def test_another_field_is_no_earlier_visit(visits: tuple[Path, Path], tmp_path: Path) -> None:
    mission = visits[0].parent / "1.toml"
    for words, reason in (
        (("--seed", 12, "--after", visits[0]), "driven with --seed 11"),
        (("--seed", 11, "--after", tmp_path), "not there, or damaged"),
        (("--seed", 11, "--after", visits[0], "--resume", visits[0]), "--after and --resume"),
    ):
        refused = rover("run", mission, "--out", tmp_path / "out", "--quiet", *words)
        assert (refused.returncode, len(refused.stderr.splitlines())) == (2, 1)
        assert reason in refused.stderr
        assert not (tmp_path / "out").exists()
