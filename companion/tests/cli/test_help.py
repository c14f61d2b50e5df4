"""Help, version and completion: what a person meets first."""

from __future__ import annotations

import os
import shlex
import subprocess
import sys

import pytest

COMMANDS = ("run", "plan", "register", "detect", "status", "doctor")


@pytest.mark.parametrize("command", COMMANDS)
def test_help_shows_worked_examples(rover, command):
    result = rover(command, "--help")
    assert result.code == 0
    assert result.err == ""
    assert f"\n    rover {command}" in result.out.partition("Examples:")[2]


def test_the_overview_names_every_command_and_exit_code(rover):
    result = rover("--help")
    assert result.code == 0
    for command in COMMANDS:
        assert f"\n  {command} " in result.out
    listed = " ".join(result.out.partition("Exit codes:")[2].split())
    for code in range(1, 9):
        assert f" {code} " in listed


def test_help_imports_nothing_heavy():
    """It is asked for often, and the first thing that anyone sees."""
    code = """
import sys
from rover.cli.commands import COMMANDS
from rover.cli.main import invoke
for command in ((), *((name,) for name in COMMANDS)):
    assert invoke([*command, "--help"]) == 0, command
    heavy = {"numpy", "cv2", "onnxruntime", "can", "serial", "rich", "pydantic"} & set(sys.modules)
    assert not heavy, (command, heavy)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr


def test_a_misspelt_command_is_told_what_may_have_been_meant(rover):
    result = rover("detekt")
    assert (result.code, result.err.count("\n")) == (2, 1)
    assert "Did you mean 'detect'" in result.err


def test_version(rover):
    result = rover("--version")
    assert (result.code, result.err) == (0, "")
    assert result.out.split()[0] == "rover"


def test_completion_offers_the_commands():
    line = [sys.executable, "-c", "from rover.cli.main import main; main()"]
    asked = {"_ROVER_COMPLETE": "complete_bash", "COMP_WORDS": "rover r", "COMP_CWORD": "1"}
    done = subprocess.run(line, env=os.environ | asked, capture_output=True, text=True, timeout=30)
    assert done.stdout.split() == ["run", "recover", "replay", "register"]


def test_a_reader_that_stops_reading_is_no_error():
    line = f"{shlex.quote(sys.executable)} -c 'from rover.cli.main import main; main()' --help"
    done = subprocess.run(["sh", "-c", f"({line}; echo $? >&2) | true"], capture_output=True, text=True, timeout=30)
    assert done.stderr in ("0\n", "")
