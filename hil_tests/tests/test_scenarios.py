"""Every scenario that ships, on each rig that it can exist on."""

from __future__ import annotations

from pathlib import Path

import pytest
from rover.errors import PreflightFailed
from rover_hil.scenario.library import shipped
from rover_hil.scenario.reading import load_scenario
from rover_hil.scenario.runner import play

FILES = shipped()


@pytest.mark.parametrize("file", FILES, ids=[file.stem for file in FILES])
def test_scenario(file: Path, rig_name: str) -> None:
    scenario = load_scenario(file)
    if rig_name not in scenario.rigs:
        pytest.skip(f"{file.stem} cannot exist on {rig_name}")
    try:
        result = play(scenario, rig_name)
    except PreflightFailed as missing:
        pytest.skip(str(missing))
    events = [f"{time:.3f} {what}" for time, what in result.track.events]
    assert result.passed, "\n".join([scenario.name, *result.failures, *events])


def test_there_are_enough_of_them_for_each_rig() -> None:
    scenarios = [load_scenario(file) for file in FILES]
    assert sum("sitl" in scenario.rigs for scenario in scenarios) >= 40
    assert sum("emulator" in scenario.rigs for scenario in scenarios) >= 25


@pytest.mark.rig("sitl")
def test_the_same_scenario_gives_the_same_run() -> None:
    scenario = load_scenario(next(file for file in FILES if file.stem == "bit-errors"))
    try:
        first, second = play(scenario, "sitl"), play(scenario, "sitl")
    except PreflightFailed as missing:
        pytest.skip(str(missing))
    assert first.track.events == second.track.events
    assert first.track.moments == second.track.moments
