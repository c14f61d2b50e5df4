"""Opens the port of a real board, whichever wire its name stands for."""

from __future__ import annotations

from rover.link.baud import DEFAULT_BAUD
from rover.link.clock import WallClock
from rover.link.frames import FrameTransport, SerialFrames
from rover.link.port import CanPort, parse_port
from rover.link.transport import SerialTransport


def open_frames(port: str, baud: int = DEFAULT_BAUD, clock: WallClock | None = None) -> FrameTransport:
    """The port of a real board, opened. Raises BadInput for a malformed name, PreflightFailed when it does not open."""
    parsed = parse_port(port)
    if isinstance(parsed, CanPort):
        from rover.link.can_bus import CanTransport  # python-can takes a quarter of a second to import

        return CanTransport(parsed, clock)
    return SerialFrames(SerialTransport(parsed, baud, clock))
