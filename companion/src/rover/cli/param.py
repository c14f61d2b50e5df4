"""`rover param`: the firmware's parameters by name."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer
from rover_protocol.parameters import BY_NAME

from rover.cli.commands import CONTEXT
from rover.cli.connection import Baud, Port, connected
from rover.cli.output import say, write_json, write_text
from rover.errors import BadInput
from rover.link.baud import DEFAULT_BAUD
from rover.link.parameter_names import checked, named
from rover.toml_table import Table

HELP = """Read and set the firmware's parameters by name.

Values are whole numbers in the parameter's own unit; docs/reference/protocol.md lists what they mean. What is set holds
until the board is switched off, and for good after a save. Nothing is set while the motors are on. A rover's own values
belong into its vehicle file: rover vehicle push writes that to the board.

\b
Examples:
  rover param list --port /dev/ttyACM0
  rover param list --port /dev/ttyACM0 --changed             those that differ from the defaults
  rover param get track dead_man --port /dev/ttyACM0
  rover param set sonar_slot=40 --port /dev/ttyACM0 --save
  rover param export --port /dev/ttyACM0 > board.toml        a file for rover param set --file
"""

app = typer.Typer(
    help=HELP, rich_markup_mode=None, add_completion=False, no_args_is_help=True, context_settings=dict(CONTEXT)
)
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON document.")]
Save = Annotated[bool, typer.Option("--save", help="Keep them over a power cycle.")]


@app.command("list")
def list_parameters(
    port: Port,
    changed: Annotated[bool, typer.Option("--changed", help="Only those that are not at their default.")] = False,
    baud: Baud = DEFAULT_BAUD,
    as_json: AsJson = False,
) -> int:
    """All parameters with value, unit, range and help."""
    from rover.link.parameters import read_parameters

    with connected(port, baud) as link:
        values = read_parameters(link)
    if changed:
        values = {name: value for name, value in values.items() if value != BY_NAME[name].default}
    _show(values, as_json)
    return 0


@app.command("get")
def get(
    names: Annotated[list[str], typer.Argument(metavar="NAME…", help="Parameters, as rover param list names them.")],
    port: Port,
    baud: Baud = DEFAULT_BAUD,
    as_json: AsJson = False,
) -> int:
    """The parameters of these names."""
    from rover.link.parameters import read_parameters

    for name in names:
        named(name)
    with connected(port, baud) as link:
        values = read_parameters(link, names)
    for name in names:
        if name not in values:
            raise BadInput(f"{name}: the firmware on {port} does not know this parameter; flash that of this version")
    _show(values, as_json)
    return 0


@app.command("set")
def set_parameters(
    port: Port,
    settings: Annotated[
        list[str] | None, typer.Argument(metavar="NAME=VALUE…", help="Whole numbers, in the parameter's unit.")
    ] = None,
    file: Annotated[Path | None, typer.Option(metavar="FILE", help="Parameters from a file, as export prints.")] = None,
    save: Save = False,
    baud: Baud = DEFAULT_BAUD,
    as_json: AsJson = False,
) -> int:
    """Set parameters in the board's memory."""
    from rover.link.parameters import command_parameters, read_parameters, write_parameters

    values = {**(_of_file(file) if file is not None else {}), **dict(_setting(text) for text in settings or [])}
    if not values:
        raise BadInput("param set: nothing to set; name a parameter, as sonar_slot=40, or a --file")
    with connected(port, baud) as link:
        write_parameters(link, values)
        if save:
            command_parameters(link, "save")
        told = read_parameters(link, values)
    _show(told, as_json)
    return 0


@app.command("save")
def save_parameters(port: Port, baud: Baud = DEFAULT_BAUD) -> int:
    """Keep what is in the board's memory over a power cycle."""
    from rover.link.parameters import command_parameters

    with connected(port, baud) as link:
        command_parameters(link, "save")
    say("saved")
    return 0


@app.command("defaults")
def defaults(port: Port, save: Save = False, baud: Baud = DEFAULT_BAUD, as_json: AsJson = False) -> int:
    """Back to the firmware's defaults; shows what has changed by that."""
    from rover.link.parameters import command_parameters, read_parameters

    with connected(port, baud) as link:
        before = read_parameters(link)
        command_parameters(link, "defaults")
        if save:
            command_parameters(link, "save")
        after = read_parameters(link)
    _show({name: value for name, value in after.items() if value != before.get(name)}, as_json)
    return 0


@app.command("export")
def export(port: Port, baud: Baud = DEFAULT_BAUD, as_json: AsJson = False) -> int:
    """All parameters as a TOML file, for set --file."""
    from rover.link.parameters import read_parameters

    with connected(port, baud) as link:
        values = read_parameters(link)
    if as_json:
        _show(values, True)
    else:
        rows = (
            f"{f'{name} = {value}':<40} # {BY_NAME[name].unit}: {BY_NAME[name].help}" for name, value in values.items()
        )
        write_text("\n".join(["[parameters]", *rows]))
    return 0


def _show(values: Mapping[str, int], as_json: bool) -> None:
    if as_json:
        write_json([document(name, value) for name, value in values.items()])
        return
    for name, value in values.items():
        known = BY_NAME[name]
        default = "" if value == known.default else f" (default {known.default})"
        write_text(f"{name:<26}{value:>12} {known.unit:<15}{known.help}{default}")


def document(name: str, value: int) -> dict[str, Any]:
    """One parameter as `--json` tells it."""
    known = BY_NAME[name]
    return {
        "name": name,
        "value": value,
        "unit": known.unit,
        "minimum": known.minimum,
        "maximum": known.maximum,
        "default": known.default,
        "safety": known.safety,
        "help": known.help,
    }


def _setting(text: str) -> tuple[str, int]:
    name, _, value = text.partition("=")
    named(name)
    try:
        return name, checked(name, int(value))
    except ValueError as error:
        if isinstance(error, BadInput):
            raise
        raise BadInput(f"{text}: a whole number is expected after the =, in {BY_NAME[name].unit}") from None


def _of_file(path: Path) -> dict[str, int]:
    table = Table.of_file(path).only("parameters").table("parameters").only(*BY_NAME)
    return {name: table.integer(name, BY_NAME[name].minimum, BY_NAME[name].maximum) for name in table.names()}
