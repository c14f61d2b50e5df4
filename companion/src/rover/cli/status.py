"""`rover status`: what the firmware on a port says of itself, and why it last stopped."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

import typer

from rover.cli.output import write_json, write_text
from rover.link.baud import DEFAULT_BAUD

HELP = """Ask the firmware on a port for its state and the reason of its last stop.

Nothing moves. While a mission drives the rover it is the mission that answers: nothing goes over the wire, and nobody
who asks can disturb it. Exit code 3 when nothing answers, 7 when the link breaks while asking.

\b
Examples:
  rover status --port /dev/ttyACM0
  rover status --port can:socketcan:can0          a CAN bus, as python-can names it: can:INTERFACE:CHANNEL
  rover status --port "$(jq -r .port runs/demo/rig.json)"        a simulated rig that lost its companion
  rover status --port /dev/ttyACM0 --json | jq -r .cause
  rover status --port /dev/ttyACM0 --crash        the record of the last crash, kept over restarts
  rover status --port /dev/ttyACM0 --crash --clear        shows it, then forgets it
"""


def command(
    port: Annotated[str, typer.Option("--port", metavar="P", help="Serial port, or can:INTERFACE:CHANNEL.")],
    baud: Annotated[int, typer.Option(min=1200, max=4_000_000, help="Bit rate of a serial port.")] = DEFAULT_BAUD,
    crash: Annotated[bool, typer.Option("--crash", help="The record of the firmware's last crash.")] = False,
    clear: Annotated[bool, typer.Option("--clear", help="With --crash: forget the record once it is shown.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON document.")] = False,
) -> int:
    """See HELP."""
    if crash or clear:
        from rover.cli.crash_record import show

        return show(port, baud, clear, as_json)
    from rover.cli.asking import ask_politely

    told = ask_politely(port, baud)
    write_json(told) if as_json else write_text(text(told))
    return 0


def text(told: Mapping[str, Any]) -> str:
    """The answer for a person."""
    battery, mission = told["battery_v"], told.get("mission")
    rows = [
        (
            "firmware",
            f"{told['firmware']} ({told['git_hash']}) on {told['board']}, started by {told['reset_cause']}, "
            f"{told['port']}",
        ),
        ("state", told["meaning"]),
        ("faults", ", ".join(told["faults"]) or "none"),
        ("motors", "powered" if told["powered"] else "off"),
        ("emergency stop", "pressed" if told["emergency_input"] else "released"),
        ("battery", "not told" if battery is None else f"{battery:.2f} V"),
        ("round trip", f"{told['round_trip_ms']:.1f} ms"),
    ]
    if mission is not None:
        rows.append(("mission", f"{mission['says']}; in {told['run']}"))
    return "\n".join(f"{name:<15} {value}" for name, value in rows)
