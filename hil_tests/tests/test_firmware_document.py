"""docs/reference/firmware.md has the supervisor's table as the source has it."""

from __future__ import annotations

import re
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[2]


def table_of_source() -> dict[str, list[str]]:
    """Event to cells, in the order of the states, with the row of states under the name `event`."""
    source = (REPOSITORY / "firmware/core/src/supervisor.rs").read_text(encoding="utf-8")
    cells = {"NONE": "–"}
    for name, state, action in re.findall(r"const (\w+): Cell = Some\(\(State::(\w+), Action::(\w+)\)\);", source):
        cells[name] = state if action == "Nothing" else f"{state}, {action}"
    order = source[source.index("const STATES") : source.index("const NONE")]
    table = {"event": re.findall(r"State::(\w+)", order)}
    for event, row in re.findall(r"\(Event::(\w+), +\[([^\]]+)\]\)", source):
        table[event] = [cells[name.strip()] for name in row.split(",")]
    return table


def table_of_document() -> dict[str, list[str]]:
    text = (REPOSITORY / "docs/reference/firmware.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (\w+) \| (.+) \|$", text[text.index("| event | Boot") : text.index("This table")], re.M)
    return {event: cells.split(" | ") for event, cells in rows}


def test_the_supervisor_table_is_that_of_the_source() -> None:
    source = table_of_source()
    assert len(source) == 20, "nineteen events and the heading"
    assert table_of_document() == source
