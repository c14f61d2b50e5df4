"""What other packages add to the companion, registered as entry points in their pyproject.toml.

    [project.entry-points."rover.rigs"]
    sitl = "rover_hil.client.process:start"

The companion imports none of those packages: it looks a name up in a group, and says what is missing when nobody
registered it. `rover_hil`, the simulated rigs, is the one that ships with this project.
"""

from __future__ import annotations

from typing import Any

from rover.errors import PreflightFailed

# Modules of commands, as those in `rover.cli`: `app`, or `HELP` and `command`.
COMMANDS = "rover.commands"

# Functions of a RigOptions and the path of a log that start a rig, see `rover.link.rig`.
RIGS = "rover.rigs"

# Kinds of frame sources: functions of a location, see `rover.capture.source`.
CAMERAS = "rover.cameras"

# Functions without arguments that return a line for `rover doctor`, or raise RoverError with what is wrong.
CHECKS = "rover.checks"

RIG_PACKAGE = "rover-hil"


def names(group: str) -> tuple[str, ...]:
    """What is registered in a group, in alphabetical order."""
    from importlib.metadata import entry_points  # takes longer to import than all else that `rover --help` needs

    return tuple(sorted(entry_points(group=group).names))


def load(group: str, name: str) -> Any:
    """The object registered under that name. Raises PreflightFailed when there is none or it cannot be imported."""
    from importlib.metadata import entry_points

    found = tuple(entry_points(group=group, name=name))
    if not found:
        raise missing(f"{group.rpartition('.')[2].removesuffix('s')} {name!r}")
    try:
        return found[0].load()
    except ImportError as error:
        raise PreflightFailed(f"{name} cannot be used ({error}): run 'make setup'") from error


def missing(what: str) -> PreflightFailed:
    """One line for what only the rigs bring."""
    return PreflightFailed(f"{what} comes with the package {RIG_PACKAGE}, which is not installed: run 'make setup'")
