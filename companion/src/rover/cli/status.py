"""`rover status`: what the firmware on a port says of itself, and why it last stopped."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from rover.cli.output import write_json, write_text
from rover.link.baud import DEFAULT_BAUD
from rover.link.firmware_document import firmware_document

if TYPE_CHECKING:
    from rover.cli.probe import Answer

HELP = """Ask the firmware on a port for its state and the reason of its last stop.

Nothing moves. Exit code 3 when nothing answers, 7 when the link breaks while asking.

\b
Examples:
  rover status --port /dev/ttyACM0
  rover status --port can:socketcan:can0          a CAN bus, as python-can names it: can:INTERFACE:CHANNEL
  rover status --port "$(jq -r .port runs/demo/rig.json)"        a simulated rig that lost its companion
  rover status --port /dev/ttyACM0 --json | jq -r .cause
"""


def command(
    port: Annotated[str, typer.Option("--port", metavar="P", help="Serial port, or can:INTERFACE:CHANNEL.")],
    baud: Annotated[int, typer.Option(min=1200, max=4_000_000, help="Bit rate of a serial port.")] = DEFAULT_BAUD,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON document.")] = False,
) -> int:
    """See HELP."""
    from rover.cli.probe import ask

    answer = ask(port, baud)
    if as_json:
        write_json(document(answer, port))
    else:
        write_text(text(answer, port))
    return 0


def document(answer: Answer, port: str) -> dict[str, Any]:
    """The answer as JSON."""
    return firmware_document(port, answer.identity, answer.state, answer.battery, answer.figures)


def text(answer: Answer, port: str) -> str:
    """The answer for a person."""
    identity, state = answer.identity, answer.state
    rows = [
        (
            "firmware",
            f"{identity.version} ({identity.git_hash}) on {identity.board}, started by {identity.reset_cause}, {port}",
        ),
        ("state", answer.meaning),
        ("faults", ", ".join(state.faults) or "none"),
        ("motors", "powered" if state.powered else "off"),
        ("emergency stop", "pressed" if state.emergency_input else "released"),
        ("bumper", "pressed" if state.bumper else "free"),
        ("battery", "not told" if answer.battery is None else f"{answer.battery.voltage:.2f} V"),
        ("round trip", f"{answer.figures.round_trip_median * 1e3:.1f} ms"),
    ]
    return "\n".join(f"{name:<15} {value}" for name, value in rows)
