"""How fast a replay goes: as fast as it can, or in real time at a rate, with a pause and a start offset."""

from __future__ import annotations

import contextlib
import os
import select
import signal
import sys
import termios
import time
import tty
from collections.abc import Iterator

POLL_S = 0.05
SPACE = b" "


class Pace:
    """Call `wait` with the recording's time. Without a rate it returns at once unless paused.

    `start`: seconds of the recording that are gone through without waiting; estimators and firmware need them.
    """

    def __init__(self, rate: float | None = None, start: float = 0.0, paused: bool = False) -> None:
        self._rate = rate
        self._start = start
        self.paused = paused
        self._origin: tuple[float, float] | None = None

    def toggle(self) -> None:
        """Pauses, or goes on."""
        self.paused = not self.paused
        self._origin = None

    def wait(self, at: float) -> None:
        """Returns when it is time for what happened `at` seconds of the recording."""
        if at < self._start:
            return
        while self.paused:
            self._look_at_keys(POLL_S)
        if self._rate is None:
            return
        now = time.monotonic()
        if self._origin is None:
            self._origin = (now, at)
        due = self._origin[0] + (at - self._origin[1]) / self._rate
        while (left := due - time.monotonic()) > 0.0:
            if self._look_at_keys(min(left, POLL_S)):
                return self.wait(at)
        return None

    def _look_at_keys(self, seconds: float) -> bool:
        """Waits for so long, or for a key; whether it is paused then."""
        if not sys.stdin.isatty():
            time.sleep(seconds)
        elif select.select([sys.stdin], [], [], seconds)[0] and os.read(sys.stdin.fileno(), 1) == SPACE:
            self.toggle()
        return self.paused

    @contextlib.contextmanager
    def controlled(self) -> Iterator[None]:
        """While this runs SIGUSR1, or the space bar where there is a terminal, pauses and goes on."""
        before = signal.signal(signal.SIGUSR1, lambda *_: self.toggle())
        keys = (self._rate is not None or self.paused) and sys.stdin.isatty()
        settings = termios.tcgetattr(sys.stdin) if keys else None
        try:
            if settings is not None:
                tty.setcbreak(sys.stdin)
            yield
        finally:
            signal.signal(signal.SIGUSR1, before)
            if settings is not None:
                termios.tcsetattr(sys.stdin, termios.TCSADRAIN, settings)
