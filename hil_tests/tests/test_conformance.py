"""The flashed ELF against the core on the desktop: 20 s of a driven mission, the same inputs, tick by tick."""

from __future__ import annotations

import os
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest
from rover.errors import PreflightFailed
from rover_hil.firmware_process import emulator_command, sitl_command
from rover_hil.testing.conformance import OFF_BY_ONE, Compared, Conformance, differing_messages
from rover_hil.tick_recorder import read_ticks, write_launcher

MISSION = Path(__file__).resolve().parent / "missions" / "wide.toml"
TICKS = 20_000

pytestmark = pytest.mark.rig("emulator")


@pytest.fixture(scope="module")
def compared(tmp_path_factory: pytest.TempPathFactory) -> tuple[list[Compared], Conformance]:
    """A mission on sitl is recorded; its ticks go through both."""
    try:
        board, sitl = emulator_command(), sitl_command()
    except PreflightFailed as missing:
        pytest.skip(str(missing))
    folder = tmp_path_factory.mktemp("conformance")
    launcher = write_launcher(folder, folder / "ticks.bin")
    rover = Path(sys.executable).with_name("rover")
    command = [str(rover), "run", str(MISSION), "--seed", "5", "--out", str(folder / "run")]
    done = subprocess.run(command, env={**os.environ, "ROVER_SITL": str(launcher)}, capture_output=True, check=False)
    ticks = list(read_ticks(folder / "ticks.bin"))[:TICKS]
    assert len(ticks) == TICKS, f"{len(ticks)} ticks: {done.stderr.decode()[-500:]}"
    conformance = Conformance(board, sitl)
    return list(conformance.run(ticks)), conformance


def test_a_driven_mission_gives_the_same_outputs_in_every_tick(
    compared: tuple[list[Compared], Conformance],
) -> None:
    results, _ = compared
    assert len(results) == TICKS
    driven = sum(result.sitl.flags & 1 and result.sitl.duty != (0, 0) for result in results)
    assert driven > 4_000, "the mission drives"
    differing = [result for result in results if result.sitl != result.board]
    assert differing == [], f"{len(differing)} ticks differ, the first: {differing[0]}"


def test_both_say_the_same_in_the_same_tick(compared: tuple[list[Compared], Conformance]) -> None:
    _, conformance = compared
    assert conformance.faulty_frames == 0
    said = Counter(message.name for message in conformance.messages[0])
    assert said["WheelTicks"] >= TICKS // 20 - 1
    assert said["MotionStatus"] >= TICKS // 50 - 1
    assert said["Sonar"] > 500
    assert said["ClockReply"] > 40
    differing = list(differing_messages(*conformance.messages))
    assert differing == [], f"{len(differing)} messages differ, the first: {differing[0]}"
    pairs = zip(*conformance.messages, strict=True)
    unequal = [mine for mine, yours in pairs if mine.name in OFF_BY_ONE and mine != yours]
    assert len(unequal) <= TICKS // 10_000, "edges meet rarely"
