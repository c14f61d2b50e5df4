"""The record of a firmware's last crash, as JSON and for a person."""

from __future__ import annotations

from typing import Any

from rover.cli.connection import connected
from rover.cli.output import write_json, write_text
from rover.link.crash import Crash, clear_crash, read_crash


def show(port: str, baud: int, clear: bool, as_json: bool) -> int:
    """Asks and prints; `clear` forgets it afterwards. Raises PreflightFailed, LinkLost."""
    with connected(port, baud) as link:
        crash = read_crash(link)
        if clear:
            clear_crash(link)
    if as_json:
        write_json(document(crash))
    else:
        write_text(text(crash))
    return 0


def document(crash: Crash | None) -> dict[str, Any]:
    """`cause` is null when there is no record; then there is nothing else."""
    if crash is None:
        return {"cause": None}
    counter = crash.program_counter
    return {
        "cause": crash.cause,
        "program_counter": None if counter is None else f"0x{counter:08x}",
        "line": crash.line,
        "task": crash.task,
        "uptime_s": crash.uptime_s,
        "stack_bytes": crash.stack_bytes,
        "events": [{"time_s": event.time_s, "event": event.text} for event in crash.events],
    }


def text(crash: Crash | None) -> str:
    """For a person."""
    if crash is None:
        return "no crash is recorded"
    where = "at an unknown place" if crash.program_counter is None else f"at 0x{crash.program_counter:08x}"
    line = "" if crash.line is None else f", line {crash.line} of its source"
    head = f"{crash.cause} in {crash.task} {where}{line}, {crash.uptime_s:.3f} s after the start"
    rows = [f"{event.time_s:>10.3f} s  {event.text}" for event in crash.events]
    return "\n".join([head, f"stack: {crash.stack_bytes} bytes at most", *rows])
