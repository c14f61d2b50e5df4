"""A mission on the emulated board ends as on sitl: same detections, same path."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest
from rover.errors import PreflightFailed
from rover_hil.compare import compare, matched
from rover_hil.firmware_process import emulator_command, sitl_command

MISSIONS = Path(__file__).resolve().parent / "missions"


# Exit code of a mission whose time was over.
PARTIAL = 8


@pytest.mark.rig("emulator")
def test_a_whole_mission_over_the_serial_line_is_driven_alike_on_both_rigs(tmp_path: Path) -> None:
    assert driven_on_both(tmp_path, MISSIONS / "real-time.toml", "serial") == [0, 0]


@pytest.mark.rig("emulator")
def test_the_beginning_of_a_mission_over_can_is_driven_alike_on_both_rigs(tmp_path: Path) -> None:
    mission = tmp_path / "beginning.toml"
    mission.write_text(re.sub(r"max_duration_s = .*", "max_duration_s = 12.0", (MISSIONS / "small.toml").read_text()))
    assert driven_on_both(tmp_path, mission, "can") == [PARTIAL, PARTIAL]


def driven_on_both(folder: Path, mission: Path, transport: str) -> list[int]:
    """Exit codes of the runs, which must be alike."""
    try:
        emulator_command()
        sitl_command()
    except PreflightFailed as missing:
        pytest.skip(str(missing))
    rover = str(Path(sys.executable).with_name("rover"))
    codes = []
    for rig in ("sitl", "emulator"):
        command = [rover, "run", str(mission), "--rig", rig, "--transport", transport, "--out", str(folder / rig)]
        codes.append(subprocess.run([*command, "--quiet"], check=False, timeout=400).returncode)
    comparison = compare(folder / "sitl", folder / "emulator")
    assert comparison.alike, comparison
    assert comparison.detections_matched >= 1
    # Not only near: the firmware is given the same and says the same in every tick.
    assert comparison.at_equal_times_m < 1e-3
    return codes


def test_places_are_paired_once_and_only_within_two_centimetres_and_their_class() -> None:
    one = [{"class": "buried", "x": 1.0, "y": 1.0}, {"class": "surface", "x": 2.0, "y": 1.0}]
    assert matched(one, one) == 2
    assert matched(one, [{"class": "buried", "x": 1.019, "y": 1.0}]) == 1
    assert matched(one, [{"class": "buried", "x": 1.021, "y": 1.0}]) == 0
    assert matched(one, [{"class": "surface", "x": 1.0, "y": 1.0}]) == 0
    assert matched([one[0]], [one[0], one[0]]) == 1
