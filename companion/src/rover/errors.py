"""Errors that end a command, each with the exit code that scripts rely on."""

from __future__ import annotations

# What an exit code of any command means: one thing each, as the pages, the help and the scenarios say it.
EXIT_CODES = {
    0: "done",
    1: "unexpected error",
    2: "usage or bad input",
    3: "pre-flight failed",
    4: "no path",
    5: "ended by the operator",
    6: "safety stop",
    7: "link lost",
    8: "partial, can be resumed",
}


class RoverError(Exception):
    """An expected failure: one clear line for the user and an exit code for scripts."""

    exit_code = 1


class BadInput(RoverError, ValueError):
    """A file, option or value that the user can correct."""

    exit_code = 2


class PreflightFailed(RoverError):
    """Something that must be there before the rover may move is missing."""

    exit_code = 3


class NoPath(RoverError):
    """No collision-free path exists."""

    exit_code = 4


class Aborted(RoverError):
    """The operator ended the mission."""

    exit_code = 5


class SafetyStop(RoverError):
    """The firmware stopped the rover and the mission could not go on."""

    exit_code = 6


class LinkLost(RoverError):
    """The wire to the firmware is gone or silent."""

    exit_code = 7
