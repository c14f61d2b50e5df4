"""Every scenario that ships on `sitl`; on `emulator` one for each kind of wiring, as it takes far longer.

`rover hil run --all --rig emulator` runs all.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from rover.errors import PreflightFailed
from rover_hil.scenario.catalogue import FAULTS
from rover_hil.scenario.library import shipped
from rover_hil.scenario.reading import load_scenario
from rover_hil.scenario.runner import play

FILES = shipped()
ON_THE_EMULATOR = (
    "can-bus-off",  # MCP2515 on SPI
    "emergency-stop-input",  # a pin's interrupt
    "encoder-stuck",  # quadrature through the PIO
    "battery-low-at-arming",  # converter
    "firmware-hang",  # watchdog
    "brown-out",  # start of the chip
    "motor-stalled-slow",  # PWM and bridge
    "serial-cut",  # UART
    "sonar-dead-comes-back",  # trigger and echo
    "reboot-disarmed",  # reset by software
)


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """One test for each scenario and each rig that it runs on here, marked with the rig."""
    if "on_rig" not in metafunc.fixturenames:
        return
    wanted = metafunc.config.getoption("--rig") or ("sitl", "emulator")
    pairs = [(file, "sitl") for file in FILES] + [(file, "emulator") for file in FILES if file.stem in ON_THE_EMULATOR]
    metafunc.parametrize(
        ("file", "on_rig"),
        [
            pytest.param(file, rig, marks=pytest.mark.rig(rig), id=f"{file.stem}-{rig}")
            for file, rig in pairs
            if rig in wanted and rig in load_scenario(file).rigs
        ],
    )


def test_scenario(file: Path, on_rig: str) -> None:
    scenario = load_scenario(file)
    try:
        result = play(scenario, on_rig)
    except PreflightFailed as missing:
        pytest.skip(str(missing))
    events = [f"{time:.3f} {what}" for time, what in result.track.events]
    assert result.passed, "\n".join([scenario.name, *result.failures, *events])


def test_the_ones_for_the_emulator_can_exist_there() -> None:
    chosen = [load_scenario(file) for file in FILES if file.stem in ON_THE_EMULATOR]
    assert len(chosen) == len(ON_THE_EMULATOR)
    assert all("emulator" in scenario.rigs for scenario in chosen)
    assert {scenario.transport for scenario in chosen} == {"serial", "can"}


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


def test_every_fault_is_driven_by_a_scenario_that_ships() -> None:
    driven = {injection.fault for file in FILES for injection in load_scenario(file).injections}
    assert driven == set(FAULTS)
