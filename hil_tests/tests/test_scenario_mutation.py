"""The mutation run can still find every guard, and a scenario does notice when one is gone."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from rover.errors import BadInput, PreflightFailed
from rover_hil.firmware_process import find_binary
from rover_hil.scenario.library import FOLDER
from rover_hil.scenario.mutate import ROOT, Edit, check_places, complaints, load_mutations, locate


def test_every_guard_is_where_the_mutation_run_takes_it_out() -> None:
    assert check_places(load_mutations()) == []


def test_every_scenario_is_named_for_a_guard() -> None:
    assert complaints(load_mutations(), {}) == []


def test_a_scenario_that_does_not_notice_is_named() -> None:
    assert "serial-cut passes without the guard 'dead-man'" in complaints(load_mutations(), {"dead-man": []})


def test_a_place_that_is_gone_or_ambiguous_is_named(tmp_path: Path) -> None:
    (tmp_path / "a.rs").write_text("x = 1;\n")
    (tmp_path / "b.rs").write_text("x = 1;\ny = 2;\n")
    assert locate(tmp_path, Edit(".", "y = 2;", "")).name == "b.rs"
    with pytest.raises(BadInput, match=r"'x = 1;' stands there 2 times"):
        locate(tmp_path, Edit(".", "x = 1;", ""))


@pytest.mark.rig("sitl")
def test_a_scenario_fails_without_its_guard(tmp_path: Path) -> None:
    try:
        find_binary()
    except PreflightFailed as missing:
        pytest.skip(str(missing))
    guard = next(m for m in load_mutations() if m.guard == "a silent link is lost").edits[0]
    package = tmp_path / "rover"
    subprocess.run(["cp", "-r", str(ROOT / "companion" / "src" / "rover"), str(package)], check=True)
    session = package / "link" / "session.py"
    session.write_text(session.read_text().replace(guard.find, guard.replace))
    played = subprocess.run(
        [sys.executable, "-m", "rover_hil.scenario.verdicts", "--rig", "sitl", str(FOLDER / "serial-cut.toml")],
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert played.stdout.strip() == '{"serial-cut": false}'
