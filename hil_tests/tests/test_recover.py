"""A run out of its log: the whole log gives the run again, a damaged one all that came before the damage."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from rover.errors import BadInput
from rover_hil.replay.recover import recover

from .small_mission import MISSION, Run

pytestmark = pytest.mark.rig("sitl")

ROVER = Path(sys.executable).with_name("rover")


def rover(*arguments: object) -> subprocess.CompletedProcess[str]:
    command = [str(part) for part in (ROVER, *arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.fixture(scope="module")
def run(small_mission: Callable[..., Run]) -> Path:
    """The folder of a whole run."""
    whole: Run = small_mission()
    assert whole.code == 0, whole.said
    return whole.out


def summary(folder: Path) -> dict[str, Any]:
    content: dict[str, Any] = json.loads((folder / "summary.json").read_text())
    return content


def test_the_whole_log_gives_the_run_again(run: Path, tmp_path: Path) -> None:
    recover(run, tmp_path)
    for name in ("survey.npz", "keyframes.npz", "trajectory.tum"):
        assert (tmp_path / name).read_bytes() == (run / name).read_bytes(), name
    first, again = summary(run), summary(tmp_path)
    for key in ("status", "reason", "mission", "duration_s", "distance_m", "detections", "goals", "surveyed_m2"):
        assert again[key] == first[key], key
    assert again["recovered_until_s"] == pytest.approx(first["duration_s"], abs=0.5)
    assert again["collisions"] is None  # no referee has seen this


@pytest.mark.parametrize("share", [0.1, 0.6])
def test_a_log_that_is_cut_gives_all_up_to_its_end(run: Path, tmp_path: Path, share: float) -> None:
    whole = (run / "mission.mcap").read_bytes()
    (tmp_path / "cut.mcap").write_bytes(whole[: int(share * len(whole))])
    result = recover(tmp_path / "cut.mcap", tmp_path / "out")
    assert result.status == "partial"
    assert result.recovered_until is not None
    assert result.reason == f"the run was cut off: recovered from its log, {result.recovered_until:.1f} s"
    assert 0.0 < result.recovered_until <= summary(run)["duration_s"] + 0.5
    assert {path.name for path in (tmp_path / "out").iterdir()} >= {"summary.json", "report.html", "trajectory.tum"}


@pytest.mark.parametrize("place", [0.2, 0.5])
def test_flipped_bits_cost_what_follows_them(run: Path, tmp_path: Path, place: float) -> None:
    damaged = bytearray((run / "mission.mcap").read_bytes())
    start = int(place * len(damaged))
    for index in range(start, start + 2000, 41):
        damaged[index] ^= 0x5A
    (tmp_path / "flipped.mcap").write_bytes(damaged)
    result = recover(tmp_path / "flipped.mcap", tmp_path / "out")
    assert result.status == "partial"
    assert result.recovered_until is not None
    assert result.recovered_until < summary(run)["duration_s"]


def test_a_recovered_run_is_gone_on_from(run: Path, tmp_path: Path) -> None:
    whole = (run / "mission.mcap").read_bytes()
    cut = tmp_path / "cut"
    cut.mkdir()
    for name in ("truth.tum", "truth.json", "truth_seen.npz"):
        (cut / name).write_bytes((run / name).read_bytes())
    (cut / "mission.mcap").write_bytes(whole[: int(0.7 * len(whole))])
    done = rover("recover", cut, "--out", tmp_path / "recovered", "--json", "--quiet")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["recovered_until_s"] > 5.0
    options = ("--seed", "1", "--resume", tmp_path / "recovered", "--out", tmp_path / "more", "--quiet")
    ended = rover("run", MISSION, *options)
    assert ended.returncode == 0, ended.stderr


@pytest.mark.parametrize("content", [b"", b"no log at all", b"\x89MCAP0\r\n" + 64 * b"\xff"])
def test_what_is_no_log_is_one_line_and_leaves_nothing(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "mission.mcap").write_bytes(content)
    with pytest.raises(BadInput) as refused:
        recover(tmp_path, tmp_path / "out")
    assert len(str(refused.value).splitlines()) == 1
    assert not (tmp_path / "out").exists()


def test_a_run_is_not_recovered_over_itself(run: Path) -> None:
    done = rover("recover", run, "--out", run, "--force")
    assert (done.returncode, "the run to recover is there" in done.stderr) == (2, True)
