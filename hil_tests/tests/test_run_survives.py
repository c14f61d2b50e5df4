"""What is left of a run that is cut off, refused or out of disk, and that earlier runs are left alone."""

from __future__ import annotations

import json
import os
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from rover.errors import PreflightFailed
from rover.mission.run_folder import RUN_FILES
from rover_hil.firmware_process import find_binary

pytestmark = pytest.mark.rig("sitl")

MISSION = Path(__file__).resolve().parent / "missions" / "small.toml"
ROVER = Path(sys.executable).with_name("rover")
PATIENCE_S = 240.0
SEED = "3"


@pytest.fixture(autouse=True)
def firmware() -> None:
    try:
        find_binary()
    except PreflightFailed as missing:
        pytest.skip(str(missing))


def start(*options: object, before: Callable[[], None] | None = None) -> subprocess.Popen[str]:
    command = [str(part) for part in (ROVER, "run", MISSION, "--seed", SEED, *options)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=before)


def run(*options: object, before: Callable[[], None] | None = None) -> tuple[int, str, str]:
    process = start(*options, before=before)
    out, err = process.communicate(timeout=PATIENCE_S)
    return process.returncode, out, err


def wait_for(file: Path, process: subprocess.Popen[str]) -> None:
    deadline = time.monotonic() + PATIENCE_S
    while not file.exists():
        assert process.poll() is None
        assert time.monotonic() < deadline
        time.sleep(0.05)


def test_a_killed_run_is_gone_on_from_where_it_was(tmp_path: Path) -> None:
    cut, more = tmp_path / "cut", tmp_path / "more"
    process = start("--out", cut, "--quiet")
    wait_for(cut / "survey.npz", process)
    process.kill()
    process.communicate()
    assert not (cut / "summary.json").exists()
    wait = time.monotonic() + 20.0
    while not (cut / "truth_seen.npz").exists() and time.monotonic() < wait:
        time.sleep(0.05)  # the rig tells where the rover stands once it has noticed

    code, _, err = run("--out", more, "--resume", cut, "--quiet", "--json")
    assert code == 0, err
    summary = json.loads((more / "summary.json").read_text())
    assert (summary["collisions"], summary["keepout_violations"]) == (0, 0)
    assert summary["mines"]["with_contrast_found"] == summary["mines"]["with_contrast"]


def test_a_terminal_that_hangs_up_ends_a_run_in_order(tmp_path: Path) -> None:
    process = start("--out", tmp_path / "run", "--quiet", "--json")
    wait_for(tmp_path / "run" / "survey.npz", process)
    process.send_signal(signal.SIGHUP)
    out, _ = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 5
    assert json.loads(out)["reason"] == "ended by the operator"
    assert (tmp_path / "run" / "report.html").exists()


def test_a_disk_that_takes_no_more_of_the_log_costs_the_rest_of_the_log(tmp_path: Path) -> None:
    def small_files() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (900_000, 900_000))

    code, out, err = run("--out", tmp_path / "run", "--quiet", before=small_files)
    assert code == 8
    assert out.startswith("small: partial (the log can no longer be written: File too large)\n")
    assert f"to go on: rover run {MISSION} --resume {tmp_path / 'run'}" in out
    assert "Traceback" not in err
    for name in ("survey.npz", "keyframes.npz", "summary.json", "report.html", "trajectory.tum"):
        assert (tmp_path / "run" / name).stat().st_size > 0


@pytest.mark.parametrize(
    ("options", "code"),
    [
        (("--rig", "device"), 2),
        (("--rig", "device", "--port", "/dev/ttyNONE9", "--camera-source", "v4l2:/dev/video99"), 3),
        (("--data", "nowhere"), 2),
        (("--resume", "nowhere"), 2),
    ],
)
def test_a_run_that_does_not_set_off_touches_no_other(tmp_path: Path, options: tuple[str, ...], code: int) -> None:
    """Neither the run that is there, nor what else lies beside it, nor with --force."""
    old = tmp_path / "old"
    old.mkdir()
    for name in (*RUN_FILES, "notes.txt"):
        (old / name).write_text(name)
    for more in (("--out", old, "--force"), ("--out", old), ("--out", tmp_path / "new")):
        assert run(*options, *more, "--quiet")[0] in (code, 2)
    assert {path.name: path.read_text() for path in old.iterdir()} == {name: name for name in (*RUN_FILES, "notes.txt")}
    assert sorted(path.name for path in tmp_path.iterdir()) == ["old"]


def test_a_rig_that_does_not_start_leaves_no_folder(tmp_path: Path) -> None:
    environment = {**os.environ, "ROVER_SITL": str(tmp_path / "none")}
    command = [str(part) for part in (ROVER, "run", MISSION, "--out", tmp_path / "a" / "b", "--quiet")]
    ended = subprocess.run(command, capture_output=True, text=True, env=environment)
    assert ended.returncode == 3, ended.stderr
    assert list(tmp_path.iterdir()) == []


def test_two_runs_at_once_into_one_folder_are_one_run(tmp_path: Path) -> None:
    first = start("--out", tmp_path / "run", "--quiet", "--json")
    wait_for(tmp_path / "run" / "rig.json", first)
    for force in ((), ("--force",)):
        code, _, err = run("--out", tmp_path / "run", "--quiet", *force)
        assert code == 2
        assert f"--out {tmp_path / 'run'}: another run is writing there" in err
    first.send_signal(signal.SIGINT)
    assert json.loads(first.communicate(timeout=PATIENCE_S)[0])["status"] == "aborted"
