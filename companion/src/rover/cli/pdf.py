"""`rover pdf`: a run's report as a PDF."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rover.cli.output import write_json, write_text

HELP = """Print a run's report to a PDF of A4 pages.

It is made from the run's report.html, with WeasyPrint: make setup-pdf installs it. rover run --pdf makes it with the
run, so that it is in the run's manifest.

\b
Examples:
  rover pdf runs/morning                  writes morning.pdf here
  rover pdf runs/morning --out survey.pdf
"""


def command(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="Folder of a run.")],
    out: Annotated[Path | None, typer.Option(metavar="FILE", help="The PDF.  [default: the run's name]")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as one JSON document.")] = False,
) -> int:
    """See HELP."""
    from rover.cli.out_file import spare_inputs
    from rover.errors import BadInput
    from rover.plain_file import plain_file
    from rover.report.pdf import report_pdf
    from rover.whole_file import write_whole

    report = run / "report.html"
    target = out if out is not None else Path(f"{run.resolve().name}.pdf")
    try:
        html = plain_file(report).read_text(encoding="utf-8")
    except UnicodeDecodeError:
        raise BadInput(f"{report}: damaged: not a text") from None
    except OSError as error:
        raise BadInput(f"{report}: cannot be read: {error.strerror or error}") from error
    spare_inputs(target, (report,))
    content = report_pdf(html)
    try:
        write_whole(target, content)
    except OSError as error:
        raise BadInput(f"{target}: cannot be written: {error.strerror or error}") from error
    if as_json:
        write_json({"out": str(target), "bytes": len(content)})
    else:
        write_text(str(target))
    return 0
