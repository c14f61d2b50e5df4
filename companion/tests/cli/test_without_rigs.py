"""The companion alone, as on a rover: the package of the rigs is not installed, and what needs it says so."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Callable
from pathlib import Path

import pytest
import rover as companion
import rover_protocol

RUN = "import sys; from rover.cli.main import invoke; sys.exit(invoke(sys.argv[1:]))"


@pytest.fixture(scope="module")
def alone(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., subprocess.CompletedProcess[str]]:
    """Runs Python on all installed packages but `rover_hil`: without its code and without its entry points."""
    packages = tmp_path_factory.mktemp("packages")
    for folder in {sysconfig.get_path("purelib"), sysconfig.get_path("platlib")}:
        for entry in Path(folder).iterdir():
            if entry.name == "cv2":  # finds its binaries beside the file that its __init__.py really is
                shutil.copytree(entry, packages / "cv2", copy_function=_copy_source)
            elif "rover_hil" not in entry.name and not (packages / entry.name).exists():
                (packages / entry.name).symlink_to(entry)
    sources = [str(Path(str(module.__file__)).parents[1]) for module in (companion, rover_protocol)]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([*sources, str(packages)])}

    def call(*arguments: object, code: str = RUN) -> subprocess.CompletedProcess[str]:
        # -S: without the installed packages, and so without the path files of those that are installed from a checkout.
        line = [sys.executable, "-S", "-c", code, *map(str, arguments)]
        return subprocess.run(line, env=environment, capture_output=True, text=True, timeout=60, cwd=packages)

    return call


def _copy_source(source: str, target: str) -> None:
    if source.endswith(".py"):
        shutil.copyfile(source, target)
    else:
        Path(target).symlink_to(source)


def test_the_rigs_are_not_there(alone) -> None:
    assert "No module named 'rover_hil'" in alone(code="import rover_hil").stderr


def test_help_lists_all_commands(alone) -> None:
    done = alone("--help")
    assert (done.returncode, done.stderr) == (0, "")
    assert {"run", "replay", "hil", "doctor"} <= {line.split()[0] for line in done.stdout.splitlines() if line.strip()}


@pytest.mark.parametrize(
    "line",
    [
        ("hil", "list", "--faults"),
        ("replay", "runs/demo-1/mission.mcap", "--rate", "1"),
        ("run", "demo", "--quiet"),
        ("run", "demo", "--rig", "emulator", "--quiet"),
        ("link", "bench", "--rig", "sitl"),
    ],
)
def test_what_needs_the_rigs_says_in_one_line_what_is_missing(alone, line) -> None:
    done = alone(*line)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (3, "", 1), done.stderr
    assert "rover-hil, which is not installed: run 'make setup'" in done.stderr


def test_the_help_of_a_missing_command_says_what_it_needs(alone) -> None:
    done = alone("hil", "--help")
    assert done.returncode == 0
    assert "rover-hil" in done.stdout


def test_the_simulated_camera_says_what_it_needs(alone) -> None:
    done = alone(code="from rover.capture import open_source; open_source('simulator:demo')")
    assert "the frame source 'simulator' comes with the package rover-hil" in done.stderr


def test_the_doctor_of_a_real_rover_does_not_miss_the_rigs(alone) -> None:
    checks = {check["name"]: check for check in json.loads(alone("doctor", "--json").stdout)["checks"]}
    assert checks["simulated rigs"]["ok"]
    assert "rover-hil" in checks["simulated rigs"]["detail"]
    assert not {"rover_plant", "rover-sitl"} & set(checks)
