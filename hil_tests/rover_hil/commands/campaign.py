"""`rover campaign`: many missions on Ray, and how often something went wrong."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path
from typing import Annotated

import typer
from rover.cli.output import write_json, write_text
from rover.errors import BadInput

HELP = """Drive many missions, drawn from stated distributions, and tell every rate with its bounds.

Each mission has a row of figures (missions.parquet); the folder of a run stays where the file's rule keeps it. Missions
run on Ray: on this computer's cores, or with --address on a cluster whose nodes share the folder. What was stopped goes
on with --continue; a worker that is lost loses nothing. Takes the extra [campaign]: make setup-campaign.

\b
Examples:
  rover campaign --example > campaign.toml
  rover campaign campaign.toml --out campaigns/first
  rover campaign campaign.toml --out campaigns/first --continue
  rover campaign campaign.toml --out campaigns/second --against campaigns/first     another build, the same missions
  rover campaign campaign.toml --address 10.0.0.5:6379 --out /shared/first
"""


def command(
    file: Annotated[Path | None, typer.Argument(metavar="FILE.toml", help="The campaign file.")] = None,
    example: Annotated[bool, typer.Option("--example", help="Print a commented file that runs.")] = False,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Folder for rows, runs and report.  [default: campaigns/DATE-…]")
    ] = None,
    address: Annotated[str | None, typer.Option(metavar="A", help="A Ray cluster.  [default: this computer]")] = None,
    workers: Annotated[int | None, typer.Option(min=1, max=1024, help="At once here.  [default: cores]")] = None,
    go_on: Annotated[bool, typer.Option("--continue", help="Drive what is missing of the campaign in --out.")] = False,
    against: Annotated[
        Path | None, typer.Option(metavar="DIR", help="The same campaign by another build: is the difference real?")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as one JSON document.")] = False,
) -> int:
    """See HELP."""
    from rover_hil.campaign.file import example as example_file
    from rover_hil.campaign.file import load_campaign

    if example:
        write_text(example_file().rstrip("\n"))
        return 0
    if file is None:
        raise BadInput("name a campaign file, or give --example for one to begin with")
    campaign = load_campaign(file)
    folder = out or Path("campaigns") / f"{datetime.now():%Y%m%d-%H%M%S}-{file.stem}"
    if go_on and out is None:
        raise BadInput("--continue: which campaign? name its folder with --out")

    from rover.cli.progress import progress
    from rover.errors import PreflightFailed

    try:
        from rover_hil.campaign.conduct import conduct
    except ImportError as error:
        raise PreflightFailed(f"a campaign takes the extra [campaign] ({error}): run 'make setup-campaign'") from None
    from rover_hil.campaign.report import lines

    with progress(campaign.name) as shown:
        told = conduct(campaign, folder, go_on, address, workers, against, shown)
    if as_json:
        write_json(told)
    else:
        write_text(lines(told))
    return 0
