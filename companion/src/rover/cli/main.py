"""The entry point of `rover`: subcommands, exit codes, and errors as one line on stderr."""

from __future__ import annotations

import os
import sys
import traceback
from collections.abc import Sequence
from typing import Annotated, Any

import typer
from typer.main import get_command

import rover
from rover.cli.commands import CONTEXT, Commands
from rover.cli.output import say, silence, write_text
from rover.errors import EXIT_CODES, Aborted, BadInput, RoverError

UNEXPECTED = 1
CODES = ", ".join(f"{code} {meaning}" for code, meaning in EXIT_CODES.items())
HELP = f"""A landmine-detection rover: run missions, and use each of their parts by itself.

Exit codes: {CODES}.

\b
Examples:
  rover doctor                              is everything there that a mission needs?
  rover run demo                            a whole mission on the simulated rig
  rover run field.toml --seed 7 --json      the same for a script
  rover status --port /dev/ttyACM0          why did the rover stop?
"""


app = typer.Typer(
    name="rover",
    cls=Commands,
    help=HELP,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings=dict(CONTEXT),
)


def _version(wanted: bool) -> None:
    if wanted:
        write_text(f"rover {rover.__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    """Options of every command."""


def invoke(arguments: Sequence[str] | None = None) -> int:
    """Runs one command line (without the program's name) and returns its exit code. Raises nothing."""
    try:
        code = get_command(app).main(
            args=None if arguments is None else list(arguments), prog_name="rover", standalone_mode=False
        )
        sys.stdout.flush()
        return code if isinstance(code, int) else 0
    except RoverError as error:
        say(str(error))
        return error.exit_code
    except (KeyboardInterrupt, typer.Abort):
        say("interrupted")
        return Aborted.exit_code
    except BrokenPipeError:
        silence(sys.stdout)
        return 0
    except SystemExit as error:  # shell completion ends this way, and help that nobody reads to its end
        if isinstance(error.__context__, BrokenPipeError):
            silence(sys.stdout)
            return 0
        return error.code if isinstance(error.code, int) else UNEXPECTED
    except Exception as error:
        # Usage errors come from typer's parser, whose classes moved between its versions; all have this method.
        if hasattr(error, "format_message"):
            say(_usage(error))
            return BadInput.exit_code
        return _unexpected(error)


def main() -> None:
    """The installed command."""
    sys.exit(invoke())


def _usage(error: Any) -> str:
    context = getattr(error, "ctx", None)
    path = context.command_path if context is not None else "rover"
    # Newer versions of typer let their validation library's wording through.
    message = str(error.format_message()).replace("Value error, ", "").strip().rstrip(".")
    return f"{message} (see {path} --help)"


def _unexpected(error: Exception) -> int:
    if os.environ.get("ROVER_DEBUG", "") not in ("", "0"):
        traceback.print_exception(error)
        hint = ""
    else:
        hint = " (ROVER_DEBUG=1 shows where)"
    say(f"unexpected error: {type(error).__name__}: {error}{hint}")
    return UNEXPECTED


if __name__ == "__main__":
    main()
