"""`rover console`: the operator's page."""

from __future__ import annotations

import importlib.util
import json
from pathlib import Path
from typing import Annotated, Any

import typer

from rover.cli.output import say, write_text
from rover.errors import PreflightFailed

HELP = """Serve the operator's page: plan, drive, judge and review surveys in a browser.

The first line of stdout is JSON: url, pairing_code for who may operate, viewer_code for who may look on. Without
--listen only this computer reaches the page; from another network use a tunnel, see docs/guide/console.md. Missions
started here are processes of their own: the end of the console or of a browser changes nothing for them. Comes with
the extra [console].

\b
Examples:
  rover console
  rover console --runs surveys
  rover console --listen 0.0.0.0:8080
"""

EXTRA = ("starlette", "uvicorn", "websockets", "tomli_w")


def command(
    listen: Annotated[
        str, typer.Option(metavar="HOST:PORT", help="Where to listen; port 0 takes a free one.")
    ] = "127.0.0.1:8080",
    runs: Annotated[Path, typer.Option(metavar="DIR", help="Folder of the runs.")] = Path("runs"),
) -> int:
    """See HELP."""
    missing = [name for name in EXTRA if importlib.util.find_spec(name) is None]
    if missing:
        raise PreflightFailed(
            f"rover console needs {', '.join(missing)}: install the extra [console], as by 'make setup-console'"
        )
    from rover.console.serve import serve

    serve(listen, runs, _ready)
    return 0


def _ready(told: dict[str, Any]) -> None:
    write_text(json.dumps(told))
    say(f"open {told['url']} and pair with {told['pairing_code']}; Ctrl-C ends the page, not a mission")
