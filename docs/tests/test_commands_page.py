"""docs/reference/commands.md lists the commands that exist, with options that exist."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
from rover.cli.main import app
from typer.main import get_command

PAGE = Path(__file__).resolve().parents[1] / "reference/commands.md"
ROWS = re.findall(
    r"`rover ([^`]+)`", "\n".join(re.findall(r"^\| (`rover .+?) \| ", PAGE.read_text("utf-8"), re.MULTILINE))
)


def inside(group: Any) -> dict[str, Any]:
    """A group's commands by name; none in a command. Typer's classes moved between its versions: they are not named."""
    if not hasattr(group, "list_commands"):
        return {}
    context = group.context_class(group)
    return {name: group.get_command(context, name) for name in group.list_commands(context)}


def found(words: list[str]) -> tuple[str, Any]:
    """The command that the words of a usage line begin with, and its full name."""
    command: Any = get_command(app)
    name: list[str] = []
    while commands := inside(command):
        name.append(words[len(name)])
        assert name[-1] in commands, f"rover {' '.join(name)} does not exist"
        command = commands[name[-1]]
    return " ".join(name), command


def existing(command: Any, name: str = "") -> set[str]:
    """Full names of a command, or of all commands in a group."""
    commands = inside(command)
    return {name} if not commands else set().union(*(existing(c, f"{name} {n}".strip()) for n, c in commands.items()))


@pytest.mark.slow
def test_every_command_has_its_row_and_no_other() -> None:
    assert {found(row.split())[0] for row in ROWS} == existing(get_command(app))


@pytest.mark.parametrize("row", ROWS)
def test_every_option_of_a_row_exists(row: str) -> None:
    name, command = found(row.split())
    options = {option for parameter in command.params for option in parameter.opts}
    assert set(re.findall(r"--[\w-]+", row)) <= options, name
