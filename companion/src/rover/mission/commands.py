"""What the operator may say to a mission on its way: by signals, or over the socket of `rover tell`."""

from __future__ import annotations

from dataclasses import dataclass

from rover.str_enum import StrEnum


class Word(StrEnum):
    """pause: stand and wait. go: drive on. home: end the survey and drive back. skip: leave a goal out. stop: end.

    emergency: cut the motors at once, and end.
    """

    PAUSE = "pause"
    GO = "go"
    HOME = "home"
    SKIP = "skip"
    STOP = "stop"
    EMERGENCY = "emergency"


@dataclass(frozen=True)
class Command:
    """goal: the name of the goal to skip, as `place-3`, or its number; "" for the other words."""

    word: Word
    goal: str = ""
