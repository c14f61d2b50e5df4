"""The flashed ELF against the core on the desktop: a minute of a driven mission, the same inputs, tick by tick."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from rover.errors import PreflightFailed
from rover_hil.firmware_process import find_elf, sitl_command

pytest.importorskip("rp2040py", reason="rp2040py is not installed: run 'make setup-dev'")
from rover_hil.emulator.conformance import Compared, Conformance, snap
from rover_hil.tick_recorder import Tick, read_ticks, write_launcher

MISSION = Path(__file__).resolve().parent / "missions" / "minute.toml"
TICKS = 60_000


@pytest.fixture(scope="module")
def compared(tmp_path_factory: pytest.TempPathFactory) -> tuple[list[Tick], list[Compared], Conformance]:
    """A mission on sitl is recorded; its ticks go through both."""
    try:
        elf, sitl = find_elf(), sitl_command()
    except PreflightFailed as missing:
        pytest.skip(str(missing))
    folder = tmp_path_factory.mktemp("conformance")
    launcher = write_launcher(folder, folder / "ticks.bin")
    rover = Path(sys.executable).with_name("rover")
    command = [str(rover), "run", str(MISSION), "--seed", "5", "--out", str(folder / "run")]
    done = subprocess.run(command, env={**os.environ, "ROVER_SITL": str(launcher)}, capture_output=True, check=False)
    ticks = list(read_ticks(folder / "ticks.bin"))[:TICKS]
    assert len(ticks) == TICKS, f"{len(ticks)} ticks: {done.stderr.decode()[-500:]}"
    conformance = Conformance(elf, sitl)
    return ticks, list(conformance.run(ticks)), conformance


@pytest.mark.rig("emulator")
def test_a_minute_of_a_driven_mission_gives_the_same_outputs_in_every_tick(
    compared: tuple[list[Tick], list[Compared], Conformance],
) -> None:
    ticks, results, _ = compared
    assert len(results) == len(ticks) - 1
    driven = sum(result.sitl.powered and result.sitl.duty != (0, 0) for result in results)
    assert driven > 10_000, "the mission drives"
    differing = [result for result in results if result.sitl != result.board]
    assert differing == [], f"{len(differing)} ticks differ, the first: {differing[0]}"


def test_snapped_echoes_end_in_the_middle_of_a_tick_and_stay_within_a_tick_of_what_was_heard() -> None:
    for echo_us in range(120, 24_000, 37):
        assert abs(snap(echo_us) - echo_us) <= 420
        assert 200 <= (430 + snap(echo_us)) % 1000 <= 800
