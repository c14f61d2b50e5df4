"""Ctrl-C during a mission: the first stops it in order, the second cuts the motors, the third ends the program.

A request to end, or a terminal that has gone away, stops it in order, too.
"""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Protocol


class Stoppable(Protocol):
    """`rover.mission.run.Control`, without importing all that a mission needs."""

    stop: bool
    emergency: bool


@contextmanager
def operator_signals(control: Stoppable, say: Callable[[str], None]) -> Iterator[None]:
    """Turns SIGINT, SIGTERM and SIGHUP into `control` while the block runs; `say` tells what was understood."""

    def on_interrupt(_: int, __: FrameType | None) -> None:
        if control.emergency:
            raise KeyboardInterrupt
        if control.stop:
            control.emergency = True
            say("emergency stop: cutting the motors (Ctrl-C once more gives up without a report)")
        else:
            control.stop = True
            say("stopping; the report will be written (Ctrl-C again for an emergency stop)")

    def on_terminate(_: int, __: FrameType | None) -> None:
        control.stop = True

    before = [
        (number, signal.signal(number, handler))
        for number, handler in (
            (signal.SIGINT, on_interrupt),
            (signal.SIGTERM, on_terminate),
            (signal.SIGHUP, on_terminate),
        )
    ]
    try:
        yield
    finally:
        for number, handler in before:
            signal.signal(number, handler)
