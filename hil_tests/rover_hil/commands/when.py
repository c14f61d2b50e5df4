"""`rover when`: the hours at which mines show at a site, from the heat model."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rover.cli.output import write_json, write_text
from rover.errors import BadInput

if TYPE_CHECKING:
    from rover_hil.outlook import Outlook

HELP = """Say which hours to survey, and how deep mines can be expected to be seen then.

SITE.toml has one table: [site] with soil, latitude_deg, date = "YYYY-MM-DD", and if known cloud (0 to 1), air_c =
[lowest, highest] and depths_cm. The day is simulated by the heat model of the rigs. For each depth: the hour at which a
mine stands out most from what ground does by itself, the two hours that together show it best, and how much better. d'
is the mine's contrast in standard deviations of such ground. A model is no promise: look at the ground.

\b
Examples:
  rover when docs/examples/site.toml
  rover when docs/examples/site.toml --date 2026-10-01
  rover when --example > site.toml
  rover when site.toml --json | jq '.hours[] | select(.seen_to_cm >= 2) | .hour'
"""


def command(
    site: Annotated[
        Path | None, typer.Argument(metavar="SITE.toml", help="Soil, latitude, date and weather.")
    ] = None,
    date: Annotated[
        datetime | None, typer.Option(formats=["%Y-%m-%d"], metavar="D", help="Another day than the file's.")
    ] = None,
    example: Annotated[bool, typer.Option("--example", help="Print a commented file that runs.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON document.")] = False,
) -> int:
    """See HELP."""
    from rover_hil.outlook import EXAMPLE, on_day, outlook, read_site

    if example:
        write_text(EXAMPLE.rstrip("\n"))
        return 0
    if site is None:
        raise BadInput("name a site file, or give --example for one to begin with")
    place = read_site(site)
    told = summary(outlook(place if date is None else on_day(place, date.date())))
    if as_json:
        write_json(told)
    else:
        write_text(text(told))
    return 0


def summary(day: Outlook) -> dict[str, Any]:
    """The JSON."""
    from rover_hil.outlook import SEEN_K

    centimetres = [round(100.0 * depth, 2) for depth in day.site.depths]
    seen = day.seen()
    hours = []
    for index, hour in enumerate(day.hour.tolist()):
        deepest = [depth for depth, is_seen in zip(centimetres, seen[:, index], strict=True) if is_seen]
        contrast = {
            f"{depth:g}": round(float(k), 2) for depth, k in zip(centimetres, day.contrast[:, index], strict=True)
        }
        at = {"time": clock(hour), "hour": clock(hour)}
        hours.append({**at, "contrast_k": contrast, "seen_to_cm": max(deepest, default=None)})
    depths: list[dict[str, Any]] = []
    for index, depth in enumerate(centimetres):
        best, pair = day.best_hour(index), day.best_pair(index)
        alone, together = float(day.single[index, best]), float(day.pair[index][pair])
        depths.append(
            {
                "depth_cm": depth,
                "hour": clock(float(day.hour[best])),
                "contrast_k": round(float(day.contrast[index, best]), 2),
                "d_prime": round(alone, 2),
                "two_hours": [clock(float(day.hour[each])) for each in pair],
                "two_hours_d_prime": round(together, 2),
                "two_hours_gain": round(together / max(alone, 1e-9), 2),
                "hours_seen": [
                    clock(hour) for hour, is_seen in zip(day.hour.tolist(), seen[index], strict=True) if is_seen
                ],
            }
        )
    told = depths[day.deepest()]
    return {
        "soil": day.site.soil,
        "seen_from_k": SEEN_K,
        # For the deepest mines that are seen at all.
        "for_depth_cm": told["depth_cm"],
        "best": told["hour"],
        "best_pair": told["two_hours"],
        "depths": depths,
        "hours": hours,
    }


def clock(hour: float) -> str:
    """Local solar time."""
    return f"{int(hour):02d}:{round(hour % 1.0 * 60.0):02d}"


def spans(hours: list[str], step_min: int = 30) -> str:
    """Runs of hours as "from to to"; a dash where there are none."""
    minutes = [60 * int(hour[:2]) + int(hour[3:]) for hour in hours]
    runs: list[list[int]] = []
    for minute in minutes:
        if runs and minute - runs[-1][1] == step_min:
            runs[-1][1] = minute
        else:
            runs.append([minute, minute])
    return ", ".join(f"{clock(first / 60)} to {clock(last / 60)}" for first, last in runs) or "none"


def text(told: dict[str, Any]) -> str:
    """For a person."""
    lines = [f"{told['soil']}; a mine is expected to be seen from {told['seen_from_k']:g} K on (local solar time)"]
    for row in told["depths"]:
        first, second = row["two_hours"]
        lines += [
            f"{row['depth_cm']:g} cm: best at {row['hour']} ({row['contrast_k']:+.1f} K, d' {row['d_prime']:.1f}), "
            f"twice at {first} and {second} (d' {row['two_hours_d_prime']:.1f}, {row['two_hours_gain']:.1f} times)",
            f"  seen: {spans(row['hours_seen'])}",
        ]
    first, second = told["best_pair"]
    depth = f"for mines {told['for_depth_cm']:g} cm deep"
    lines.append(f"{depth}: once at {told['best']}, or twice at {first} and {second}")
    return "\n".join(lines)
