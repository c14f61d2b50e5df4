"""The commands of `rover`: each is imported when it is called or asked for its help, so that `rover --help` is quick.

A command is a module with `HELP` and a function `command`, or with `app`, a typer application of subcommands.
"""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from types import ModuleType
from typing import Any

import typer
from typer.core import TyperGroup
from typer.main import get_command, get_group

from rover import plugins
from rover.errors import Aborted

# Every command of the project with a line about it, in the order of `rover --help`.
COMMANDS: Mapping[str, str] = {
    "run": "A mission, start to report.",
    "tell": "Says something to a mission on its way.",
    "console": "The operator's page, in a browser.",
    "recover": "Report and survey of a run that was cut off.",
    "replay": "A recorded stream back into a rig, compared.",
    "compare": "What differs between two surveys of one field.",
    "verify": "A run's files against its manifest and signature.",
    "pdf": "A run's report as a PDF.",
    "when": "Which hours to survey, and how deep mines show then.",
    "plan": "A path through goals on a map.",
    "trajectory": "A path to constant-jerk segments.",
    "register": "Where one picture lies in another.",
    "stitch": "Many pictures into one mosaic.",
    "track": "A folder of frames to camera poses.",
    "calibrate": "A camera from pictures of a board, its mount, or a pair of cameras.",
    "decode": "A radiometric picture to temperatures.",
    "capture": "Pictures of a source into a folder.",
    "locate": "A pixel's place on the ground, and back.",
    "detect": "Candidates in pictures, and their classes.",
    "grid": "Pictures to a binary occupancy grid.",
    "status": "Why a rover stopped, asked over its port.",
    "bringup": "Measures a rover that has just been built, step by step.",
    "monitor": "What a rover's firmware tells, live.",
    "jog": "The wheels by hand.",
    "vehicle": "The vehicle file, and the board's copy of it.",
    "param": "The firmware's parameters by name.",
    "flash": "Writes the firmware to the board and asks it for its self-test.",
    "doctor": "What is installed, what is connected.",
    "link": "Measures the link to the firmware.",
    "campaign": "Many missions: how often something goes wrong, with its bounds.",
    "hil": "Fault scenarios on a rig, or a rig by itself.",
}

# Those that the simulated rigs bring, see `rover.plugins`.
FROM_RIGS = ("recover", "replay", "when", "campaign", "hil")

CONTEXT: Mapping[str, Any] = {"help_option_names": ["-h", "--help"], "max_content_width": 110}


class Commands(TyperGroup):
    """The group of all commands. The parser's own classes moved between typer's versions: their types are not named."""

    def invoke(self, ctx: Any) -> Any:
        """As the base class; Ctrl-C outside a mission counts as ended by the operator.

        Here, because the parser has exit codes of its own for what passes through it.
        """
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            raise Aborted("interrupted") from None

    def list_commands(self, ctx: Any) -> list[str]:
        """The project's, then what other packages add."""
        return [*COMMANDS, *(name for name in plugins.names(plugins.COMMANDS) if name not in COMMANDS)]

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """The command of that name, imported now; None when there is none. Raises PreflightFailed."""
        if cmd_name in COMMANDS and cmd_name not in FROM_RIGS:
            return _parsed(cmd_name, importlib.import_module(f"rover.cli.{cmd_name}"))
        if cmd_name in plugins.names(plugins.COMMANDS):
            return _parsed(cmd_name, plugins.load(plugins.COMMANDS, cmd_name))
        return _refusal(cmd_name) if cmd_name in FROM_RIGS else None

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """As the base class, which looks in `commands` for what a misspelt name may have meant."""
        names: dict[str, Any] = dict.fromkeys(self.list_commands(ctx))
        self.commands = names
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """As the base class, without importing what has a line here."""
        rows = [
            (name, COMMANDS[name] if name in COMMANDS else self.get_command(ctx, name).get_short_help_str())
            for name in self.list_commands(ctx)
        ]
        with formatter.section("Commands"):
            formatter.write_dl(rows)


def _parsed(name: str, module: ModuleType) -> Any:
    """A module's command as the parser takes it."""
    if hasattr(module, "app"):
        parsed: Any = get_group(module.app)
    else:
        made = _application()
        made.command(name, help=module.HELP, short_help=COMMANDS.get(name))(module.command)
        parsed = get_command(made)
    parsed.name = name
    return parsed


def _refusal(name: str) -> Any:
    """In the place of a command whose package is not installed: its help says so, and calling it does."""
    reason = plugins.missing(f"rover {name}")
    made = _application()

    @made.command(
        name,
        help=str(reason),
        short_help=COMMANDS[name],
        context_settings={"ignore_unknown_options": True, "allow_extra_args": True},
    )
    def refuse(context: typer.Context) -> None:
        raise reason

    return get_command(made)


def _application() -> typer.Typer:
    return typer.Typer(rich_markup_mode=None, add_completion=False, context_settings=dict(CONTEXT))
