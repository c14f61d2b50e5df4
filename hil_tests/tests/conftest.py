"""The rigs that the tests of this folder run: each test that takes `rig` runs on every rig of `--rig`."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from rover.errors import PreflightFailed
from rover_hil.serve import RIGS
from rover_hil.testing.rigs import RunningRig, start_rig


def pytest_addoption(parser: pytest.Parser) -> None:
    """Which rigs; both simulated ones by default."""
    parser.addoption("--rig", action="append", choices=tuple(RIGS), help="run tests of rigs on this one only")


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """One test for each rig, marked with it."""
    if "rig_name" in metafunc.fixturenames:
        chosen = metafunc.config.getoption("--rig") or list(RIGS)
        parameters = [pytest.param(name, marks=pytest.mark.rig(name)) for name in chosen]
        metafunc.parametrize("rig_name", parameters)


@pytest.fixture
def rig(rig_name: str, tmp_path: Path) -> Iterator[Callable[..., RunningRig]]:
    """Starts rigs of the demo mission with the given options; they are stopped at the end of the test."""
    try:
        RIGS[rig_name].command()
    except PreflightFailed as missing:
        pytest.skip(str(missing))
    running: list[RunningRig] = []

    def start(*options: str) -> RunningRig:
        running.append(start_rig(tmp_path / f"control{len(running)}", "--rig", rig_name, *options))
        return running[-1]

    yield start
    for one in running:
        one.stop()
