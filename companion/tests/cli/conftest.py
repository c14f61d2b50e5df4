"""A command line run in this process: its exit code and what it wrote."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
from rover.cli.main import invoke

MISSION = """
[mission]
name = "small"
max_duration_s = 60.0
goals = []

[area]
width_m = 2.0
height_m = 2.0
obstacles = [[1.0, 1.5, 0.2]]

[launch]
x_m = 0.5
y_m = 0.5
"""


@dataclass(frozen=True)
class Outcome:
    """What one command line did."""

    code: int
    out: str
    err: str


@pytest.fixture
def rover(capfd: pytest.CaptureFixture[str]) -> Callable[..., Outcome]:
    """Runs `rover` with these arguments."""

    def call(*arguments: object) -> Outcome:
        code = invoke([str(argument) for argument in arguments])
        captured = capfd.readouterr()
        return Outcome(code, captured.out, captured.err)

    return call


@pytest.fixture
def mission_file(tmp_path: Path) -> Callable[..., Path]:
    """Writes a small mission file, with one piece of its text replaced."""

    def write(old: str = "", new: str = "") -> Path:
        assert old in MISSION
        file = tmp_path / "mission.toml"
        file.write_text(MISSION.replace(old, new) if old else MISSION, encoding="utf-8")
        return file

    return write


@pytest.fixture(scope="module")
def free_rig() -> Iterator[Callable[[str], str]]:
    """Starts a rig in real time with that wire, and returns its port."""
    pytest.importorskip("rover_hil")
    running: list[subprocess.Popen[str]] = []

    def start(transport: str) -> str:
        line = [sys.executable, "-m", "rover.cli.main", "hil", "serve", "demo", "--free-run", "--transport", transport]
        rig = subprocess.Popen(line, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        running.append(rig)
        assert rig.stdout is not None
        assert rig.stderr is not None
        announced = rig.stdout.readline()
        if not announced:
            pytest.skip(f"the sitl rig does not start: {rig.stderr.read()}")
        return str(json.loads(announced)["port"])

    yield start
    for rig in running:
        rig.terminate()
        rig.communicate()
