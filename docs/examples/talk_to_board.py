"""Asks a board who it is, what it measures and how it is set. Nothing moves.

    python docs/examples/talk_to_board.py /dev/ttyACM0

The port may be a serial device, a bus as can:INTERFACE:CHANNEL, or the port of a simulated rig.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator

from rover.link.clock import WallClock
from rover.link.opening import open_frames
from rover.link.session import STEP_S, Link
from rover.link.telemetry import Battery, SonarRange

SENSORS = ("left", "centre", "right")
# Number of the parameter, see docs/reference/protocol.md.
DEAD_MAN = 1


def ask(port: str, seconds: float = 1.0) -> Iterator[str]:
    """Lines about the board on this port. Raises PreflightFailed when nothing answers."""
    clock = WallClock()
    link = Link(open_frames(port, clock=clock), clock)
    identity = link.connect()
    yield f"firmware {identity.version} on {identity.board}, started by {identity.reset_cause}"
    yield f"dead-man after {link.get_parameter(DEAD_MAN).value} ms"
    ranges: dict[int, SonarRange] = {}
    battery: Battery | None = None
    end = clock.now() + seconds
    while clock.now() < end:
        for event in link.poll():
            if isinstance(event, SonarRange):
                ranges[event.sensor] = event
            elif isinstance(event, Battery):
                battery = event
        clock.advance(clock.now() + STEP_S)
    assert link.state is not None  # connect() has waited for it
    yield f"state {link.state.state}, faults: {', '.join(link.state.faults) or 'none'}"
    if battery is not None:
        yield f"battery {battery.voltage:.2f} V"
    for sensor, echo in sorted(ranges.items()):
        yield f"sonar {SENSORS[sensor]}: {echo.status if echo.range_m is None else f'{echo.range_m:.2f} m'}"
    link.close()


if __name__ == "__main__":
    for line in ask(sys.argv[1]):
        print(line, flush=True)
