"""Everything that is missing is said at once, before anything is installed."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parents[1] / "prerequisites.sh"


def program(folder: Path, name: str, script: str) -> str:
    path = folder / name
    path.write_text(f"#!/bin/sh\n{script}\n")
    path.chmod(0o755)
    return str(path)


def check(python: str, cargo: str, path: str = "/usr/local/bin:/usr/bin:/bin") -> subprocess.CompletedProcess[str]:
    return subprocess.run([SCRIPT, python, cargo], env={"PATH": path}, capture_output=True, text=True, check=False)


@pytest.fixture
def cargo(tmp_path: Path) -> str:
    return program(tmp_path, "cargo", "echo 'cargo 1.95.0 (f2d3ce0bd 2026-03-21)'")


def test_nothing_is_said_when_all_is_there(cargo: str) -> None:
    done = check(sys.executable, cargo)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_all_that_is_missing_is_said_at_once() -> None:
    done = check("no-such-python", "no-such-cargo")
    assert done.returncode == 1
    assert "missing: Python 3.10 or newer ('no-such-python' was not found" in done.stderr
    assert "missing: Rust 1.87 or newer ('no-such-cargo' was not found" in done.stderr
    assert done.stderr.endswith("nothing was installed; install what is missing and run make again\n")


@pytest.mark.parametrize(("version", "good"), [("1.86.9", False), ("1.87.0", True), ("2.0.0", True)])
def test_an_old_rust_is_named_with_its_version(tmp_path: Path, version: str, good: bool) -> None:
    done = check(sys.executable, program(tmp_path, "cargo", f"echo 'cargo {version}'"))
    assert (done.returncode == 0) == good
    assert good or f"is {version}" in done.stderr


def test_an_old_python_is_named_with_its_version(tmp_path: Path, cargo: str) -> None:
    old = program(tmp_path, "python", '[ "$1" = -V ] && echo Python 3.9.2 || exit 1')
    assert "is Python 3.9.2;" in check(old, cargo).stderr


def test_a_python_without_venv_is_told_which_package_brings_it(tmp_path: Path, cargo: str) -> None:
    bare = program(tmp_path, "python", 'case "$2" in *ensurepip*) exit 1 ;; esac')
    assert "apt-get install python3-venv" in check(bare, cargo).stderr
