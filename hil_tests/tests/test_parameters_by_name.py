"""`rover param` and `rover vehicle` on a rig in real time: taken or refused by the firmware, kept over a restart."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from rover.link.clock import WallClock
from rover.link.frames import FrameTransport
from rover.link.opening import open_frames
from rover.mission.preflight import look_at_firmware
from rover.vehicle import STANDARD
from rover_hil.testing.served import ServedRig
from rover_protocol.parameters import PARAMETERS

pytestmark = pytest.mark.rig("sitl")


@dataclass(frozen=True)
class Wired:
    """An open port, and the clock that it goes by."""

    clock: WallClock
    wire: FrameTransport


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


def test_a_vehicle_file_is_pushed_compared_and_pulled(rig: ServedRig, tmp_path: Path) -> None:
    file = tmp_path / "vehicle.toml"
    file.write_text(rover("vehicle", "--example").stdout.replace("track_m = 0.20 ", "track_m = 0.214 "))
    on_it = ("--vehicle", str(file), "--port", rig.port, "--json")
    before = rover("vehicle", "diff", *on_it)
    assert before.returncode == 3
    difference = {"name": "track", "file": 214_000, "board": 200_000, "safety": True}
    assert json.loads(before.stdout) == {"differences": [difference]}
    assert json.loads(rover("vehicle", "push", *on_it).stdout) == {"differences": [difference]}
    rig.ask("fault", fault="brown-out", duration_s=0.2)
    time.sleep(1.0)
    after = rover("vehicle", "diff", *on_it)
    assert (after.returncode, json.loads(after.stdout)) == (0, {"differences": []})
    assert rover("param", "set", "wiring=5", "low_voltage=6100", "--port", rig.port).returncode == 0
    assert rover("vehicle", "pull", *on_it).returncode == 0
    text = file.read_text()
    assert "left_motor_inverted = true\n" in text
    assert "low_v = 6.1                    # the firmware stops the rover here\n" in text
    assert rover("vehicle", "diff", *on_it).returncode == 0
    assert rover("vehicle", "push", "--port", rig.port).returncode == 0


def test_a_start_names_what_differs_and_refuses_what_a_bench_has_left(rig: ServedRig) -> None:
    def finding() -> tuple[bool, str]:
        clock = WallClock()
        port = Wired(clock, open_frames(rig.port, clock=clock))
        try:
            found = {each.name: each for each in look_at_firmware(port, 7, STANDARD)}
        finally:
            port.wire.close()
        return found["vehicle"].ok, found["vehicle"].detail

    assert finding() == (True, "the board's parameters are those of the vehicle file")
    listed(rig, "set", "gain_position=9")
    assert finding() == (True, "on the board gain_position 9, 10 1/s in the file")
    listed(rig, "set", "track=210000")
    ok, detail = finding()
    assert not ok
    assert detail == (
        "on the board track 210000, 200000 um in the file; gain_position 9, 10 1/s in the file: "
        "rover vehicle push makes them equal"
    )
    for setting in ("guard_enabled=0", "dead_man=5000", "low_voltage=0"):
        listed(rig, "defaults")
        listed(rig, "set", setting)
        ok, detail = finding()
        assert (ok, detail.startswith(f"left from a bench: {setting.replace('=', ' ')}")) == (False, True), detail
    listed(rig, "defaults")
