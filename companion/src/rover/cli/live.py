"""The live view of a mission on stderr: a panel on a terminal, a line every ten seconds of the mission elsewhere."""

from __future__ import annotations

import contextlib
import math
import os
import sys
from collections.abc import Iterator
from types import TracebackType
from typing import TYPE_CHECKING, TextIO

from rich.console import Console
from rich.live import Live
from rich.panel import Panel
from rich.table import Table

if TYPE_CHECKING:
    from rover.mission.loop import Status

# Seconds of mission time between two plain lines.
LINE_PERIOD = 10.0


class MissionView:
    """Shows every Status given to it, as a context manager; never raises because of who reads stderr."""

    def __init__(
        self, title: str, quiet: bool = False, stream: TextIO | None = None, beginning: str = "starting the rig"
    ) -> None:
        """`beginning`: what is being done until the first Status comes."""
        self._title = title
        self._beginning = beginning
        self._stream = stream if stream is not None else sys.stderr
        self._quiet = quiet
        self._line_due = 0.0
        self._live: Live | None = None
        if not quiet and self._stream.isatty() and os.environ.get("TERM", "") not in ("", "dumb"):
            # No refreshing thread: the mission's loop redraws, and a Ctrl-C meets no half-drawn panel.
            self._live = Live(console=Console(file=self._stream), auto_refresh=False)

    def __enter__(self) -> MissionView:
        with self._tolerant():
            if self._live is not None:
                self._live.start()
                self._live.update(Panel(f"{self._beginning} …", title=self._title), refresh=True)
            elif not self._quiet:
                self._write(f"{self._title}: {self._beginning}")
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        with self._tolerant():
            if self._live is not None:
                self._live.stop()

    def show(self, status: Status) -> None:
        """One moment of the mission."""
        if self._quiet:
            return
        with self._tolerant():
            if self._live is not None:
                self._live.update(Panel(_table(status), title=self._title, expand=False), refresh=True)
            elif status.time >= self._line_due:
                self._line_due = (math.floor(status.time / LINE_PERIOD + 1e-9) + 1.0) * LINE_PERIOD
                self._write(plain_line(status))

    def say(self, text: str) -> None:
        """A message for the operator, also when quiet."""
        with self._tolerant():
            if self._live is not None:
                self._live.console.print(f"rover: {text}", markup=False, highlight=False)
            else:
                self._write(text)

    def _write(self, text: str) -> None:
        self._stream.write(f"rover: {text}\n")
        self._stream.flush()

    @contextlib.contextmanager
    def _tolerant(self) -> Iterator[None]:
        try:
            yield
        except (OSError, ValueError):  # the terminal is gone: the mission goes on unseen
            self._quiet, self._live = True, None


def fields(status: Status) -> list[tuple[str, str]]:
    """What is shown, as (name, value)."""
    battery = "unknown" if status.battery is None else f"{status.battery:.2f} V"
    left = "unknown" if status.remaining is None else f"about {status.remaining / 60.0:.0f} min"
    if status.energy_wh is not None and status.energy_s is not None:
        left += f"; battery for {status.energy_s / 60.0:.0f} min ({status.energy_wh:.1f} Wh)"
    trip = f"{status.round_trip * 1e3:.1f} ms" if math.isfinite(status.round_trip) else "unknown"
    factor = status.time / status.wall if status.wall > 0.0 else 0.0
    return [
        ("time", f"{status.time:.1f} s"),
        ("phase", status.phase),
        ("firmware", status.firmware),
        ("pose", f"{status.x:.2f}, {status.y:.2f} m, {math.degrees(status.heading):.0f}° ± {status.sigma:.3f} m"),
        ("goals", f"{status.goals_done}/{status.goals}"),
        ("indications", str(status.indications)),
        ("surveyed", f"{100.0 * status.surveyed:.0f} %"),
        ("battery", battery),
        ("left", left),
        ("link", f"{status.lost_frames} lost, round trip {trip}"),
        ("speed", f"{factor:.1f} x real time"),
        *([("waits for", status.waits_for)] if status.waits_for else []),
    ]


def plain_line(status: Status) -> str:
    """All of it on one line."""
    return "; ".join(f"{name} {value}" for name, value in fields(status))


def _table(status: Status) -> Table:
    table = Table.grid(padding=(0, 2))
    table.add_column(style="bold")
    table.add_column()
    for name, value in fields(status):
        table.add_row(name, value)
    return table
