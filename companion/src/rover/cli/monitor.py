"""`rover monitor`: what a rover's firmware tells, live."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rover.cli.connection import Baud, Port, connected
from rover.cli.output import say, write_text
from rover.errors import BadInput
from rover.link.baud import DEFAULT_BAUD

if TYPE_CHECKING:
    from rover.link.watching import Moment

HELP = """Show what the firmware tells, live: counts, speeds, ranges, voltage, faults, the link.

Nothing moves. On a terminal a panel is redrawn ten times a second; elsewhere, and with --json, there is a line for
each moment. --plot draws speeds, duties, ranges and voltage of the whole time as a PNG or SVG, or writes them as CSV.
While a mission drives the rover it is the mission that tells what it hears: nothing goes over the wire.

\b
Examples:
  rover monitor --port /dev/ttyACM0                          until Ctrl-C
  rover monitor --port /dev/ttyACM0 --seconds 10 --plot wheels.png
  rover monitor --port /dev/ttyACM0 --seconds 60 --plot log.csv
  rover monitor --port /dev/ttyACM0 --json | jq -c '[.left_counts, .right_counts]'
"""
PLOTS = (".png", ".svg", ".csv")


def command(
    port: Port,
    seconds: Annotated[
        float | None, typer.Option(min=0.1, max=86400.0, help="How long; without it until Ctrl-C.")
    ] = None,
    plot: Annotated[Path | None, typer.Option(metavar="FILE", help="PNG, SVG or CSV of the whole time.")] = None,
    rate: Annotated[float, typer.Option(min=0.1, max=50.0, help="Moments a second.")] = 10.0,
    baud: Baud = DEFAULT_BAUD,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object a line.")] = False,
) -> int:
    """See HELP."""
    if plot is not None and plot.suffix.lower() not in PLOTS:
        raise BadInput(f"--plot {plot}: a file that ends in {', '.join(PLOTS)} is expected")
    if plot is not None and not plot.resolve().parent.is_dir():
        raise BadInput(f"--plot {plot}: no such folder")
    moments: list[Moment] = []
    show = _as_json if as_json else _panel() if sys.stdout.isatty() else _as_line
    try:
        for moment in _moments(port, baud, 1.0 / rate, math.inf if seconds is None else seconds):
            show(moment)
            if plot is not None:
                moments.append(moment)
    except KeyboardInterrupt:  # how one ends it
        pass
    if plot is not None:
        from rover.cli.monitor_plot import write_plot

        write_plot(moments, plot)
        say(f"{len(moments)} moments in {plot}")
    return 0


def _moments(port: str, baud: int, period: float, seconds: float) -> Iterator[Moment]:
    from rover.cli.asking import watch_mission
    from rover.link.claim import PortHeld
    from rover.link.watching import watch

    try:
        with connected(port, baud) as link:
            yield from watch(link, period, seconds)
    except PortHeld as held:
        if held.holder is None or not held.holder.run:
            raise
        yield from watch_mission(Path(held.holder.run), period, seconds)


def _as_json(moment: Moment) -> None:
    write_text(json.dumps(moment.as_dict()))


def _as_line(moment: Moment) -> None:
    write_text("  ".join(f"{name} {value}" for name, value in moment.rows()))


class _panel:  # noqa: N801 - used as a function that remembers its panel
    """Redraws one table on a terminal."""

    def __init__(self) -> None:
        from rich.live import Live

        self._live = Live(auto_refresh=False)
        self._live.start()

    def __call__(self, moment: Moment) -> None:
        from rich.table import Table

        table = Table.grid(padding=(0, 2))
        for name, value in moment.rows():
            table.add_row(name, value)
        self._live.update(table, refresh=True)
