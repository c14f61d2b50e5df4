"""`rover vehicle`: the vehicle file, and the board's copy of the firmware's share."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rover.cli.commands import CONTEXT
from rover.cli.connection import Baud, Port, connected
from rover.cli.output import say, write_json, write_text
from rover.errors import BadInput, PreflightFailed
from rover.link.baud import DEFAULT_BAUD

if TYPE_CHECKING:
    from rover.vehicle import Vehicle
    from rover.vehicle.difference import Difference

HELP = """The vehicle file: one truth about a rover for companion, firmware and simulated rigs.

Without --vehicle it is the standard rover. The firmware's share of the file are its parameters; a mission compares them
with the board's before it starts, and diff does so now: exit code 0 when they are equal, 3 when not.

\b
Examples:
  rover vehicle --example > vehicle.toml                      a commented file of the standard rover
  rover vehicle push --vehicle vehicle.toml --port /dev/ttyACM0     to the board, and saved there
  rover vehicle diff --vehicle vehicle.toml --port /dev/ttyACM0
  rover vehicle pull --vehicle vehicle.toml --port /dev/ttyACM0     the board's values into the file
"""

app = typer.Typer(help=HELP, rich_markup_mode=None, add_completion=False, context_settings=dict(CONTEXT))
EQUAL = "board and file are equal"
File = Annotated[
    Path | None, typer.Option("--vehicle", metavar="FILE", help="Vehicle file; without it the standard rover.")
]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON document.")]


@app.callback(invoke_without_command=True)
def vehicle(
    context: typer.Context,
    example: Annotated[bool, typer.Option("--example", help="Print a commented vehicle file.")] = False,
) -> None:
    """See HELP."""
    if context.invoked_subcommand is not None:
        return
    if not example:
        raise BadInput("vehicle: push, pull, diff or --example? (see rover vehicle --help)")
    from rover.vehicle.file import example as text

    write_text(text().rstrip("\n"))


@app.command("push")
def push(port: Port, file: File = None, baud: Baud = DEFAULT_BAUD, as_json: AsJson = False) -> int:
    """The file's share to the board, and save it there; prints what was different."""
    from rover.link.parameters import command_parameters, read_parameters, write_parameters
    from rover.vehicle.difference import differences

    wanted = _load(file).parameters()
    with connected(port, baud) as link:
        before = differences(wanted, read_parameters(link))
        write_parameters(link, {each.name: each.file for each in before})
        if before:
            command_parameters(link, "save")
        left = differences(wanted, read_parameters(link))
    _show(before, as_json, "pushed and saved" if before else "the board had all of it already")
    if left:
        raise PreflightFailed(f"push: still different on the board: {', '.join(each.name for each in left)}")
    return 0


@app.command("diff")
def diff(port: Port, file: File = None, baud: Baud = DEFAULT_BAUD, as_json: AsJson = False) -> int:
    """What differs between file and board; exit code 0 when they are equal, 3 when not."""
    found = _compare(port, file, baud)
    _show(found, as_json, f"{len(found)} different; ! marks what safety rests on" if found else EQUAL)
    return PreflightFailed.exit_code if found else 0


@app.command("pull")
def pull(port: Port, file: File = None, baud: Baud = DEFAULT_BAUD, as_json: AsJson = False) -> int:
    """The board's values into the file; without a file, what differs from the standard rover."""
    from rover.vehicle import load_vehicle
    from rover.vehicle.firmware import entries
    from rover.vehicle.text import with_value
    from rover.whole_file import write_whole

    found = _compare(port, file, baud)
    if file is not None and found:
        before = file.read_bytes()
        text, known = before.decode(), load_vehicle(file)
        for each in found:
            if each.board is None:
                raise BadInput(f"pull: the firmware on {port} does not know {each.name}; flash that of this version")
            for entry in entries(each.name, each.board, known):
                text = with_value(text, *entry)
        write_whole(file, text.encode())
        try:
            load_vehicle(file)
        except BadInput:
            write_whole(file, before)
            raise
    _show(found, as_json, EQUAL if file is None or not found else f"written to {file}")
    return 0


def _compare(port: str, file: Path | None, baud: int) -> list[Difference]:
    from rover.link.parameters import read_parameters
    from rover.vehicle.difference import differences

    wanted = _load(file).parameters()
    with connected(port, baud) as link:
        return differences(wanted, read_parameters(link))


def _load(file: Path | None) -> Vehicle:
    from rover.vehicle import STANDARD, load_vehicle

    return STANDARD if file is None else load_vehicle(file)


def _show(found: list[Difference], as_json: bool, done: str) -> None:
    if as_json:
        told: dict[str, Any] = {"differences": [each.as_dict() for each in found]}
        write_json(told)
        return
    for each in found:
        write_text(f"{'! ' if each.safety else '  '}{each}")
    say(done)
