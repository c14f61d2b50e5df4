"""The rigs that the tests of this folder run: each test that takes `rig` runs on every rig of `--rig`."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from rover.errors import PreflightFailed
from rover_hil.firmware_process import find_binary
from rover_hil.serve import RIGS
from rover_hil.testing.rigs import RunningRig, start_rig

from .small_mission import Run, run_small

DEVICE = "device"


def pytest_addoption(parser: pytest.Parser) -> None:
    """Which rigs; both simulated ones by default."""
    parser.addoption("--rig", action="append", choices=(*RIGS, DEVICE), help="run tests of rigs on this one only")
    parser.addoption("--port", help="port of the board for --rig device")


def pytest_configure(config: pytest.Config) -> None:
    """Says what is missing before anything runs."""
    device = DEVICE in (config.getoption("--rig") or [])
    if device and config.getoption("--port") is None:
        raise pytest.UsageError("--rig device: name the board's port with --port")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """With --rig device and no other, only what runs on a board."""
    if config.getoption("--rig") == [DEVICE]:
        others = [item for item in items if not is_of_device(item)]
        items[:] = [item for item in items if is_of_device(item)]
        config.hook.pytest_deselected(items=others)
    if config.getoption("--port") is None:
        for item in filter(is_of_device, items):
            item.add_marker(pytest.mark.rig("sitl in place of a device"), append=False)


def is_of_device(item: pytest.Item) -> bool:
    """Whether a test is marked as one for a board."""
    marker = item.get_closest_marker("rig")
    return marker is not None and marker.args[0] == DEVICE


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """One test for each rig, marked with it."""
    if "rig_name" in metafunc.fixturenames:
        chosen = [name for name in metafunc.config.getoption("--rig") or RIGS if name in RIGS]
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


@pytest.fixture(scope="session")
def small_mission(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Run]:
    """Runs the small mission with a seed; each (seed, repetition) once for all tests, which only read its folder."""
    try:
        find_binary()
    except PreflightFailed as missing:
        pytest.skip(str(missing))
    done: dict[tuple[int, int], Run] = {}

    def once(seed: int = 1, repetition: int = 1) -> Run:
        if (seed, repetition) not in done:
            done[seed, repetition] = run_small(tmp_path_factory.mktemp(f"seed{seed}-{repetition}"), seed)
        return done[seed, repetition]

    return once
