"""The record of a crash, piece by piece over the link."""

from __future__ import annotations

import pytest
from rover.cli.crash_record import document, text
from rover.errors import PreflightFailed
from rover.link.crash import clear_crash, read_crash
from rover.link.session import Link

from .conftest import MemoryWorld


class Crashed:
    """Answers CrashRequest for the scripted firmware."""

    def __init__(self, world: MemoryWorld, *, clears: bool = True) -> None:
        self.world, self.clears, self.there = world, clears, True
        answer = world.firmware.answer
        world.firmware.answer = lambda name, raw, now: (  # type: ignore[method-assign]
            self.answer(raw["command"]) if name == "CrashRequest" else answer(name, raw, now)
        )

    def answer(self, command: int) -> bytes:
        frame = self.world.firmware.frame
        self.there = self.there and not (command == 1 and self.clears)
        if not self.there:
            return frame("CrashCause")
        return (
            frame("CrashCause", cause=1, task=4, detail=57, program_counter=0x1001_A000)
            + frame("CrashTime", uptime=12_345, stack=900, events=3)
            + frame("CrashEvent", index=2, kind=3, detail=4, time=12_300)
            + frame("CrashEvent", index=0, kind=1, detail=0, time=0)
            + frame("CrashEvent", index=1, kind=2, detail=2, time=310)
        )


def connected(world: MemoryWorld) -> Link:
    link = Link(world, world)
    link.connect()
    return link


def test_a_crash_is_read_in_the_order_of_its_events(world: MemoryWorld) -> None:
    link = connected(world)
    Crashed(world)
    crash = read_crash(link)
    assert document(crash) == {
        "cause": "Panic",
        "program_counter": "0x1001a000",
        "line": 57,
        "task": "Can",
        "uptime_s": 12.345,
        "stack_bytes": 900,
        "events": [
            {"time_s": 0.0, "event": "Start: PowerOn"},
            {"time_s": 0.31, "event": "State: Armed, cause None"},
            {"time_s": 12.3, "event": "Fault: Stall"},
        ],
    }
    assert text(crash).splitlines()[0] == "Panic in Can at 0x1001a000, line 57 of its source, 12.345 s after the start"


def test_a_cleared_record_is_gone_and_one_that_stays_is_told(world: MemoryWorld) -> None:
    link = connected(world)
    Crashed(world)
    clear_crash(link)
    assert read_crash(link) is None
    assert document(None) == {"cause": None}
    Crashed(world, clears=False)
    with pytest.raises(PreflightFailed, match="disarmed"):
        clear_crash(link)
