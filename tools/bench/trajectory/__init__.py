"""Paths of many kinds to segments: driven, within limits and tolerance, and what does it cost beside toppra?

    python -m tools.bench trajectory                 # 40 paths of each kind, the tables of docs/results/motion.md
    python -m tools.bench trajectory --paths 5 --json
    python -m tools.bench trajectory --kind circle --first 100

toppra gets the very path that was made of each polyline and every limit but those of jerk (toppra_peer.py). Limits are
checked on 40 states a segment, positions by an integration of their own (independent.py). "Ideal" is what toppra needs
along the smooth shape itself that a path was sampled from.
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from rover.motion.path.limits import DrivingLimits
from rover.vehicle import Vehicle

from tools.bench.trajectory.measure import Outcome, measure, planning_seconds
from tools.bench.trajectory.paths import KINDS

# Points of the paths whose planning time is taken.
SIZES = (1_000, 3_000, 10_000)


def main(arguments: list[str]) -> int:
    """Prints the tables."""
    parser = argparse.ArgumentParser(prog="python -m tools.bench trajectory", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("--paths", type=int, default=40, help="of each kind")
    parser.add_argument("--first", type=int, default=0, help="seed of the first path")
    parser.add_argument("--kind", choices=list(KINDS), help="one kind only")
    parser.add_argument("--lateral", type=float, default=0.25, help="most lateral acceleration, m/s²")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args(arguments)
    limits = DrivingLimits.of(Vehicle(), lateral=options.lateral)
    kinds = [options.kind] if options.kind else list(KINDS)
    seeds = range(options.first, options.first + options.paths)
    rows = {kind: summary([measure(kind, seed, limits) for seed in seeds]) for kind in kinds}
    times = {} if options.kind else {size: planning_seconds(size, limits) for size in SIZES}
    if options.json:
        print(json.dumps({"kinds": rows, "planning_s": times}, indent=2))
    else:
        print(tables(rows, times))
    return 0


def summary(outcomes: Sequence[Outcome]) -> dict[str, Any]:
    """The figures of one kind of path; ratios as (median, 95 %, most)."""
    driven = [each for each in outcomes if not each.refused]
    shaped = [each for each in driven if not math.isnan(each.ideal)]
    gaps = [each.least_clearance for each in driven if not math.isnan(each.least_clearance)]
    return {
        "paths": len(outcomes),
        "points": [min(each.points for each in outcomes), max(each.points for each in outcomes)],
        "refused": len(outcomes) - len(driven),
        "broken": sum(bool(each.broken) for each in driven),
        "deviation_mm": 1e3 * max((each.deviation for each in driven), default=math.nan),
        "least_clearance_mm": 1e3 * min(gaps) if gaps else None,
        "turns": sum(each.turns for each in driven),
        "metres": sum(each.length for each in driven),
        "to_toppra": spread([each.duration / each.toppra for each in driven]),
        "to_ideal": spread([each.duration / each.ideal for each in shaped]) if shaped else None,
    }


def spread(values: Sequence[float]) -> tuple[float, float, float]:
    """Median, 95th percentile and the most; nan of nothing."""
    if not values:
        return math.nan, math.nan, math.nan
    return float(np.median(values)), float(np.percentile(values, 95)), float(np.max(values))


def tables(rows: dict[str, dict[str, Any]], times: dict[int, dict[str, float]]) -> str:
    """Markdown."""
    lines = [
        "| paths | | points | refused | limits, tolerance or clearance not kept | most beside the path "
        "| least clearance "
        "| turns on the spot | time / toppra: median, p95, most | time / ideal: median, p95, most |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    for kind, row in rows.items():
        low, high = row["points"]
        gap = row["least_clearance_mm"]
        lines.append(
            f"| {kind} | {row['paths']} | {low} to {high} | {row['refused']} | {row['broken']} "
            f"| {row['deviation_mm']:.1f} mm | {'' if gap is None else f'{gap:.3f} mm'} "
            f"| {row['turns']} on {row['metres']:.0f} m | {_ratios(row['to_toppra'])} | {_ratios(row['to_ideal'])} |"
        )
    if times:
        names = list(next(iter(times.values())))
        lines += ["", f"| points | {' | '.join(names)} |", "|---|" + "---|" * len(names)]
        for size, seconds in times.items():
            lines.append(f"| {size} | {' | '.join(f'{seconds[name]:.2f} s' for name in names)} |")
    return "\n".join(lines)


def _ratios(values: object) -> str:
    if not isinstance(values, tuple):
        return ""
    return ", ".join(f"{value:.3f}" for value in values)
