"""`rover param` on a rig in real time: values by name, refused or taken as the firmware says, kept over a restart."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from rover_hil.testing.served import ServedRig
from rover_protocol.parameters import PARAMETERS

pytestmark = pytest.mark.rig("sitl")


@pytest.fixture(scope="module")
def rig() -> Iterator[ServedRig]:
    served = ServedRig("demo", "--free-run", "--no-camera")
    yield served
    served.stop()


def rover(*arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "rover.cli.main", *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=60)


def listed(rig: ServedRig, *arguments: str) -> dict[str, Any]:
    result = rover("param", *arguments, "--port", rig.port, "--json")
    assert result.returncode == 0, result.stderr
    return {row["name"]: row for row in json.loads(result.stdout)}


def test_every_parameter_is_there_with_the_range_that_its_description_gives(rig: ServedRig) -> None:
    rows = listed(rig, "list")
    assert list(rows) == [known.name for known in PARAMETERS]
    for known in PARAMETERS:
        row = rows[known.name]
        assert (row["value"], row["default"]) == (known.default, known.default)
        assert (row["unit"], row["minimum"], row["maximum"]) == (known.unit, known.minimum, known.maximum)


def test_the_firmware_holds_to_the_described_range(rig: ServedRig) -> None:
    known = next(each for each in PARAMETERS if each.name == "sonar_slot")
    refused = rover("param", "set", f"sonar_slot={known.minimum - 1}", "--port", rig.port)
    assert refused.returncode == 2
    assert f"sonar_slot: 29 lies outside {known.minimum} to {known.maximum} ms" in refused.stderr
    for value in (known.minimum, known.maximum, known.default):
        assert listed(rig, "set", f"sonar_slot={value}")["sonar_slot"]["value"] == value


def test_what_is_saved_is_there_after_a_restart_and_what_is_not_is_gone(rig: ServedRig, tmp_path: Path) -> None:
    listed(rig, "set", "sonar_slot=41", "--save")
    listed(rig, "set", "dead_man=411")
    exported = rover("param", "export", "--port", rig.port)
    assert "dead_man = 411 " in exported.stdout
    rig.ask("fault", fault="brown-out", duration_s=0.2)
    time.sleep(1.0)
    assert {name: row["value"] for name, row in listed(rig, "list", "--changed").items()} == {"sonar_slot": 41}
    file = tmp_path / "board.toml"
    file.write_text(exported.stdout, encoding="utf-8")
    assert listed(rig, "set", "--file", str(file))["dead_man"]["value"] == 411
    assert set(listed(rig, "defaults", "--save")) == {"sonar_slot", "dead_man"}
    assert listed(rig, "list", "--changed") == {}


def test_a_misspelt_name_is_answered_with_the_right_one(rig: ServedRig) -> None:
    refused = rover("param", "get", "trak", "--port", rig.port)
    assert (refused.returncode, refused.stderr) == (2, "rover: trak: no such parameter; did you mean track?\n")
