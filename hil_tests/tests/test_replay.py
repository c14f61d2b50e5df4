"""A recorded mission fed back: equal in every output on the same build, and what was changed is named."""

from __future__ import annotations

import json
import os
import shlex
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest
from rover.cli.main import invoke
from rover.errors import PreflightFailed
from rover.record.log_reader import Log
from rover_hil.firmware_process import emulator_command, find_binary
from rover_hil.parameter_file import parse_setting
from rover_hil.replay.firmware import FirmwareReplay

MISSION = Path(__file__).resolve().parent / "missions" / "look.toml"
ROVER = [sys.executable, "-m", "rover.cli.main"]
pytestmark = pytest.mark.rig("sitl")


def record(folder: Path, *options: str) -> Path:
    try:
        find_binary()
    except PreflightFailed as missing:
        pytest.skip(str(missing))
    command = [*ROVER, "run", str(MISSION), "--seed", "3", "--out", str(folder), "--quiet", *options]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120.0)
    assert done.returncode in (0, 8), done.stderr
    return folder / "mission.mcap"


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Of a short mission, recorded once."""
    return record(tmp_path_factory.mktemp("recorded"))


@pytest.fixture
def replayed(capsys: pytest.CaptureFixture[str]) -> Any:
    """Replays with options; gives exit code and document."""

    def once(log: Path, *options: str) -> tuple[int, dict[str, Any]]:
        code = invoke(["replay", str(log), "--json", "--quiet", *options])
        said = capsys.readouterr()
        assert said.out, said.err
        return code, json.loads(said.out)

    return once


def test_a_mission_replays_identically_twice_in_a_row(log: Path, replayed: Any) -> None:
    for _ in range(2):
        code, result = replayed(log)
        assert code == 0, result
        assert (result["identical"], result["first_difference"], result["build"]) == (True, None, {})
        assert result["frames"] >= 40
        assert result["parts"]["firmware"]["compared"] >= 6000
        assert result["parts"]["companion"]["compared"] >= 2000


def test_a_firmware_of_another_commit_is_named(
    log: Path, replayed: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    other = tmp_path / "rover-sitl"
    other.write_text(f'#!/bin/sh\nexec {shlex.quote(str(find_binary()))} --git-hash 0badcafe "$@"\n')
    other.chmod(0o755)
    monkeypatch.setenv("ROVER_SITL", str(other))
    code, result = replayed(log)
    assert code == 6
    assert result["build"]["firmware_git_hash"].endswith("→ 0badcafe")
    assert result["first_difference"]["field"] == "HelloBuild.git_hash"


def test_a_changed_gain_of_the_firmware_is_named(log: Path, replayed: Any) -> None:
    code, result = replayed(log, "--set", "gain_velocity=100000")
    assert code == 6
    assert not result["identical"]
    difference = result["first_difference"]
    assert difference["topic"] == "/rig/firmware"
    assert difference["field"].startswith("duty_")
    assert difference["recorded"] != difference["replayed"]
    assert 0.1 < difference["time_s"] < 6.0
    assert result["parts"]["companion"]["identical"]


def test_another_launch_of_the_companion_is_named(log: Path, replayed: Any) -> None:
    code, result = replayed(log, "--override", "launch.x_m=0.45")
    assert code == 6
    assert result["parts"]["firmware"]["identical"]
    assert not result["parts"]["companion"]["identical"]
    assert result["first_difference"]["recorded"] != result["first_difference"]["replayed"]


def test_a_mission_over_can_replays_identically(tmp_path: Path, replayed: Any) -> None:
    code, result = replayed(record(tmp_path, "--transport", "can"))
    assert code == 0, result
    assert result["identical"]


@pytest.mark.rig("emulator")
def test_a_log_of_sitl_replays_identically_on_the_emulated_board(log: Path, replayed: Any) -> None:
    try:
        emulator_command()
    except PreflightFailed as missing:
        pytest.skip(str(missing))
    code, result = replayed(log, "--rig", "emulator")
    assert code == 0, result
    assert result["parts"]["firmware"]["compared"] >= 6000


def test_a_log_that_was_cut_short_is_compared_up_to_its_end(log: Path, tmp_path: Path, replayed: Any) -> None:
    cut = tmp_path / "cut.mcap"
    content = log.read_bytes()
    cut.write_bytes(content[: len(content) // 2])
    code, result = replayed(cut)
    assert (code, result["identical"], result["cut"]) == (0, True, True)
    assert 10 < result["frames"] < 45


def test_a_log_that_was_tampered_with_is_found_out(log: Path) -> None:
    recorded = Log(log)
    steps = list(recorded.steps())
    part = FirmwareReplay([str(find_binary())], recorded.metadata["mission"])
    for index, step in enumerate(steps[:60]):
        if index == 50:
            spoiled = bytearray(step.replies[7])
            spoiled[0] ^= 1
            step = type(step)(
                step.now_us,
                step.requests,
                (*step.replies[:7], bytes(spoiled), *step.replies[8:]),
                step.to_firmware,
                step.from_firmware,
            )
        part.feed(step)
    found = part.finish()
    assert found.difference is not None
    assert found.difference.field == "duty_left"
    assert found.difference.time == pytest.approx(steps[50].start_us * 1e-6 + 0.008)


def test_at_a_rate_it_takes_its_time_and_can_be_paused(log: Path) -> None:
    command = [*ROVER, "replay", str(log), "--json", "--rate", "20", "--start", "2", "--pause"]
    pipe = subprocess.PIPE
    running = subprocess.Popen(command, stdout=pipe, stderr=pipe, stdin=subprocess.DEVNULL, text=True)
    assert running.stderr is not None
    assert "paused" in running.stderr.readline()
    time.sleep(0.5)
    assert running.poll() is None
    os.kill(running.pid, signal.SIGUSR1)
    out, _ = running.communicate(timeout=60.0)
    assert json.loads(out)["identical"]


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["README.md"], "not an MCAP log"),
        (["missing.mcap"], "no such log"),
        (["LOG", "--set", "wheel=3"], "no parameter 'wheel'"),
        (["LOG", "--set", "gain_velocity=fast"], "a whole number is expected"),
        (["LOG", "--set", "gain_velocity=90000000"], "OutOfRange"),
        (["LOG", "--override", "rover.speed=3"], "speed"),
        (["LOG", "--rate", "1", "--lock-step"], "one of them"),
        (["LOG", "--rig", "device"], "--port"),
        ([], "name the log"),
    ],
)
def test_bad_input_is_one_clear_line(
    log: Path, options: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    given = [str(log) if option == "LOG" else option for option in options]
    if given and given[0] == "README.md":
        given[0] = str(Path(__file__))
    assert invoke(["replay", *given]) == 2
    error = capsys.readouterr().err.strip()
    assert said in error
    assert len(error.splitlines()) == 1


def test_parameters_go_by_name_or_number() -> None:
    assert parse_setting("gain_velocity=100000") == parse_setting("43=100000") == (43, 100000)
