"""What `rover doctor` says of the simulated rigs: one line each, RoverError when something is missing."""

from __future__ import annotations

import importlib

from rover.errors import PreflightFailed

from rover_hil.firmware_process import find_binary


def firmware() -> str:
    """The firmware's core as a desktop process."""
    return str(find_binary())


def plant() -> str:
    """The compiled plant."""
    try:
        return str(importlib.import_module("rover_plant").__file__)
    except ImportError as error:
        raise PreflightFailed(f"not built ({error}): run 'make setup'") from error
