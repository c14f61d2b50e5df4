"""`rover recover`: report, survey and keyframes from a log, however the run ended."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rover.cli.output import say, write_json, write_text

HELP = """Rebuild report, survey and keyframes of a run from its log.

RUN is the folder of a run, or its mission.mcap. The log may be cut anywhere: what came in until then goes through the
mission again, and what the rover knew at that moment is written as if it had come to rest there. A next run resumes
from DIR. The folder of the run itself is not touched.

\b
Examples:
  rover recover runs/20260504-093015-field --out runs/recovered
  rover recover mission.mcap --out recovered --json | jq .recovered_until_s
  rover run field.toml --resume runs/recovered
"""
# Seconds of the recording between two lines of progress.
LINE_PERIOD_S = 30.0


def command(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="Folder of a run, or its log.")],
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for what is recovered, new or empty.")],
    force: Annotated[bool, typer.Option("--force", help="Replace the run that is in --out; other files stay.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as one JSON document.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress on stderr.")] = False,
) -> int:
    """See HELP."""
    from rover.cli.run import summary_text
    from rover.errors import BadInput
    from rover.mission.run_folder import check_free
    from rover.report.summary import summary

    from rover_hil.replay.recover import log_of, recover

    if log_of(run).parent.resolve() == out.resolve():
        raise BadInput(f"--out {out}: the run to recover is there; name another folder")
    check_free(out, force)
    due = LINE_PERIOD_S

    def tell(now: float) -> None:
        nonlocal due
        if now >= due and not quiet:
            due = now + LINE_PERIOD_S
            say(f"{now:.0f} s")

    result = recover(run, out, force, tell)
    for line in result.unwritten:
        say(line)
    if as_json:
        write_json(summary(result))
    else:
        write_text(summary_text(result, out / "report.html", "MISSION"))
    return 0
