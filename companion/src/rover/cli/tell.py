"""`rover tell`: speaks to a mission on its way."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from rover.cli.output import write_json, write_text
from rover.errors import BadInput

HELP = """Say something to a running mission, over the local socket in its run's folder.

pause: stand and wait; go: drive on; home: end the survey and drive back to the launch; skip ID: leave a goal out
(place-3, operator-1); stop: end where it stands, as Ctrl-C; emergency: cut the motors at once, as Ctrl-C twice; state:
ask only. Who may write into the run's folder may say this. Exit code 2 when no mission runs there, 7 when it does not
answer.

\b
Examples:
  rover tell runs/morning pause
  rover tell runs/morning skip place-3
  rover tell runs/morning home
  rover tell runs/morning state --json | jq -r .state
"""

STATE = "state"


def command(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="Folder of the running mission.")],
    word: Annotated[str, typer.Argument(metavar="WORD", help="pause, go, home, skip, stop, emergency or state.")],
    goal: Annotated[str, typer.Argument(metavar="[ID]", help="The goal, with skip.")] = "",
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON document.")] = False,
) -> int:
    """See HELP."""
    from rover.mission.commands import Word
    from rover.mission.ear import ask

    words = [STATE, *(each.value for each in Word)]
    if word not in words:
        raise BadInput(f"{word}: not known; say {', '.join(words)}")
    if (word == Word.SKIP) != bool(goal):
        raise BadInput("skip: which goal? as in rover tell RUN skip place-3" if not goal else f"{word}: takes no ID")
    answer = ask(run, {"op": word, **({"id": goal} if goal else {})})
    told = {key: value for key, value in answer.items() if key != "ok"}
    write_json(told) if as_json else write_text(text(told))
    return 0


def text(told: dict[str, Any]) -> str:
    """The answer for a person."""
    left = told.get("remaining_s")
    energy = told.get("energy_wh")
    rows = [
        ("state", told.get("says", told.get("state", "?"))),
        ("surveyed", f"{100.0 * told.get('surveyed', 0.0):.0f} %"),
        ("left", "unknown" if left is None else f"about {max(left, 0.0) / 60.0:.0f} min"),
        ("battery", "unknown" if energy is None else f"{energy:.1f} Wh until it is too low to drive"),
        ("to inspect", ", ".join(told.get("goals", [])) or "none"),
    ]
    return "\n".join(f"{name:<12} {value}" for name, value in rows)
