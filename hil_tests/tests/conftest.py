"""The rig that the tests of this folder run."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from rover.errors import PreflightFailed
from rover_hil.firmware_process import find_binary
from rover_hil.testing.rigs import RunningRig, start_rig


@pytest.fixture
def rig(tmp_path: Path) -> Iterator[Callable[..., RunningRig]]:
    """Starts rigs of the demo mission with the given options; they are stopped at the end of the test."""
    try:
        find_binary()
    except PreflightFailed as missing:
        pytest.skip(str(missing))
    running: list[RunningRig] = []

    def start(*options: str) -> RunningRig:
        running.append(start_rig(tmp_path / f"control{len(running)}", *options))
        return running[-1]

    yield start
    for one in running:
        one.stop()
