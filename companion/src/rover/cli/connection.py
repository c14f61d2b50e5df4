"""A command's connection to the firmware on a port: opened, shaken hands with, and let go of however it ends."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated

import typer

from rover.link.baud import DEFAULT_BAUD

if TYPE_CHECKING:
    from rover.link.session import Link

Port = Annotated[str, typer.Option("--port", metavar="P", help="Serial port, or can:INTERFACE:CHANNEL.")]
Baud = Annotated[int, typer.Option(min=1200, max=4_000_000, help="Bit rate of a serial port.")]


@contextmanager
def connected(port: str, baud: int = DEFAULT_BAUD) -> Iterator[Link]:
    """The only client of that port while the block runs. Raises BadInput, PreflightFailed, LinkLost."""
    from rover.link.clock import WallClock
    from rover.link.opening import open_frames
    from rover.link.session import Link

    clock = WallClock()
    link = Link(open_frames(port, baud, clock), clock)
    try:
        link.connect()
        yield link
    finally:
        link.close()
