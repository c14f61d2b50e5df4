"""`rover compare`: what differs between two surveys of one field."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from rover.cli.output import write_json, write_text

HELP = """Compare two surveys of one field: which indications are new, gone, moved, or in both.

Runs with a [site] origin are compared on the earth, others as if both had begun at the same launch. What only one
survey has is told together with whether the other has seen that ground: an indication that is gone where nobody looked
is still there.

\b
Examples:
  rover compare runs/morning runs/noon
  rover compare runs/morning runs/noon --json | jq '.new[] | [.class, .x, .y, .surveyed_before]'
"""


def command(
    before: Annotated[Path, typer.Argument(metavar="RUN_A", help="Folder of the earlier survey.")],
    after: Annotated[Path, typer.Argument(metavar="RUN_B", help="Folder of the later one.")],
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as one JSON document.")] = False,
) -> int:
    """See HELP."""
    from rover.report.survey_difference import difference, read_survey

    found = difference(read_survey(before), read_survey(after))
    if as_json:
        write_json(found)
    else:
        write_text(_text(found))
    return 0


def _text(found: dict[str, Any]) -> str:
    lines = [f"{found['before']} → {found['after']}, places compared: {found['frame']}"]
    for entry in found["both"]:
        lines.append(f"both   {_indication(entry['before'])}; later {_indication(entry['after'])}")
    for entry in found["moved"]:
        shift = f"{100.0 * entry['distance_m']:.0f} cm"
        lines.append(f"moved  {_indication(entry['before'])}, by {shift} to {_indication(entry['after'])}")
    for entry in found["new"]:
        lines.append(f"new    {_indication(entry)}{_looked(entry['surveyed_before'], 'before')}")
    for entry in found["gone"]:
        lines.append(f"gone   {_indication(entry)}{_looked(entry['surveyed_after'], 'later')}")
    counts = (f"{len(found[name])} {name}" for name in ("both", "moved", "new", "gone"))
    return "\n".join([*lines, ", ".join(counts)])


def _indication(entry: dict[str, Any]) -> str:
    return f"{entry['id']}: {entry['class']}, p {entry['p']:.2f}, at {entry['x']:.2f}, {entry['y']:.2f} m"


def _looked(seen: bool | None, when: str) -> str:
    words = {None: "not known whether it was seen", True: "that ground was seen", False: "that ground was NOT seen"}
    return f" ({words[seen]} {when})"
