"""What the rover's detector finds in each of the worlds there are to measure in, in one table.

    python -m tools.bench worlds --fields 12 --first 7000 --data DIR
    python -m tools.bench worlds --fields 12 --first 7000 --expected FILE    # also for the mission's report

Fields are driven over as by `tools.bench detector`. 95 % intervals: whole fields are drawn again.
"""

from __future__ import annotations

import argparse
import json
import math
import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rover.detection.classifier import Classifier, default_model
from rover.detection.evidence_settings import EvidenceSettings
from rover_hil.referee import FAIR_CONTRAST_K

from tools.bench.detector import CLASSES, Driven, drive_all, false_of, is_found, reports

ROUNDS = 4000
THRESHOLD = EvidenceSettings().report_threshold


def share(counts: NDArray[np.floating], digits: int) -> str:
    """Sum of the first column (fields, 2) over that of the second, with its interval."""
    drawn = np.random.default_rng(92).integers(0, len(counts), (ROUNDS, len(counts)))
    sums = counts[drawn].sum(axis=1)
    low, high = np.percentile(sums[:, 0] / np.maximum(sums[:, 1], 1e-9), (2.5, 97.5)).tolist()
    value = float(counts[:, 0].sum() / max(counts[:, 1].sum(), 1e-9))
    return f"{value:.{digits}f} [{low:.{digits}f}, {high:.{digits}f}]"


def row(name: str, runs: list[Driven]) -> str:
    """One line of the table."""
    visible, every, false = [], [], []
    for run in runs:
        told = reports(run, THRESHOLD)
        hits = [(is_found(mine, told), abs(mine.contrast_k) >= FAIR_CONTRAST_K) for mine in run.ground.mines]
        every.append((sum(hit for hit, _ in hits), len(hits)))
        visible.append((sum(hit for hit, is_fair in hits if is_fair), sum(is_fair for _, is_fair in hits)))
        false.append((false_of(run, told), run.ground.area[0] * run.ground.area[1]))
    pd, pd_all, rate = (np.array(part, float) for part in (visible, every, false))
    found = f"{share(pd, 2)} of {int(pd[:, 1].sum())} | {share(pd_all, 2)} of {int(pd_all[:, 1].sum())}"
    return f"| {name} | {len(runs)} | {found} | {share(rate, 3)} |"


def by_class(runs: list[Driven]) -> list[dict[str, Any]]:
    """Mines and those found, by contrast and by depth, with exact 95 % intervals (Clopper and Pearson): a field holds
    only one mine of each depth."""
    hits = [(mine, is_found(mine, reports(run, THRESHOLD))) for run in runs for mine in run.ground.mines]
    rows = []
    for low, high in CLASSES:
        what = f"{low:g} to {high:g} K" if math.isfinite(high) else f"{low:g} K and more"
        rows.append(_counted("contrast", what, [hit for mine, hit in hits if low <= abs(mine.contrast_k) < high]))
    for depth in sorted({mine.depth for mine, _ in hits}):
        what = f"{100.0 * depth:g} cm" if depth else "on the surface"
        rows.append(_counted("depth", what, [hit for mine, hit in hits if mine.depth == depth]))
    return rows


def _counted(by: str, what: str, hits: list[bool]) -> dict[str, Any]:
    from rover_hil.campaign.intervals import binomial_interval  # it needs scipy, which `rover` itself does without

    found, mines = sum(hits), len(hits)
    low, high = binomial_interval(found, mines)
    return {"by": by, "what": what, "mines": mines, "found": found, "low": round(low, 3), "high": round(high, 3)}


def write_expected(file: Path, runs: list[Driven], model: str, first: int) -> None:
    """What the mission's report says of the detector, as JSON that names the model."""
    area = sum(run.ground.area[0] * run.ground.area[1] for run in runs)
    false = sum(false_of(run, reports(run, THRESHOLD)) for run in runs)
    told = {
        "model": Classifier(model).sha256,
        "fields": len(runs),
        "first_seed": first,
        "threshold": THRESHOLD,
        "false_per_m2": round(false / area, 4),
        "rows": by_class(runs),
    }
    file.write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")


def main(arguments: list[str]) -> int:
    """Drives over fields of every world and prints the table."""
    parser = argparse.ArgumentParser(prog="python -m tools.bench worlds", description=__doc__.split("\n")[0])
    parser.add_argument("--fields", type=int, default=12)
    parser.add_argument("--first", type=int, default=7000, help="seed of the first field")
    parser.add_argument("--data", type=Path, default=os.environ.get("ROVER_DATA"), help="folder of real pictures")
    parser.add_argument("--model", default=default_model())
    parser.add_argument("--expected", type=Path, help="write what other soils and hours give by class")
    options = parser.parse_args(arguments)
    worlds = [("demo field, 13:00 (synthetic)", False, None), ("other soils and hours (synthetic)", True, None)]
    if options.data is not None:
        worlds.append(("demo field under real pictures' texture", False, options.data))
    print(f"| world | fields | Pd, mines of {FAIR_CONTRAST_K:g} K and more | Pd, all mines | false per m² |")
    print("|---|---|---|---|---|")
    for name, mixed, data in worlds:
        runs = drive_all(options.model, options.fields, options.first, mixed, data)
        print(row(name, runs), flush=True)
        if mixed and options.expected is not None:
            write_expected(options.expected, runs, options.model, options.first)
    return 0
