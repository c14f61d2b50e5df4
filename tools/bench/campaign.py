"""What a folder of missions comes to, worst first, with intervals: `python -m tools.bench campaign runs/bench`.

The folder is what `python -m tools.bench missions --out` leaves: one run in each `seed-N`, all of them counted.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import dataclass
from pathlib import Path
from statistics import mean, median
from typing import Any

import numpy as np
from rover.errors import BadInput
from rover.mission.fresh_ground import fresh_wheel_area
from rover.record.tum import read_tum
from rover.vehicle import STANDARD
from rover_hil.referee import FAIR_CONTRAST_K

# No field is as large; a raster of the way is taken.
FARTHEST_M = 100.0


@dataclass(frozen=True)
class Run:
    """One mission: what it says of itself, and what really was; m²."""

    summary: dict[str, Any]
    truth: dict[str, Any]
    fresh: float

    @property
    def over_mine(self) -> int:
        """Mines of fair contrast that a wheel went over."""
        rows = self.truth["verdict"]["mines"]
        return sum(row["driven_over"] and abs(row["contrast_k"]) >= FAIR_CONTRAST_K for row in rows)


def read_run(folder: Path) -> Run | None:
    """None where a mission has left no result. Raises BadInput for a damaged one."""
    if not (folder / "summary.json").is_file():
        return None
    try:
        summary = json.loads((folder / "summary.json").read_text())
        truth = json.loads((folder / "truth.json").read_text())
        poses = read_tum(folder / "truth.tum")
        if not (np.abs(poses[:, 1:3]) < FARTHEST_M).all():
            raise ValueError(f"truth.tum leaves the field by more than {FARTHEST_M:g} m")
        run = Run(summary, truth, fresh_wheel_area(np.asarray(poses)[:, 1:4], STANDARD))
        report([run])  # has everything in it that is counted
    except (OSError, ValueError, IndexError, RecursionError) as error:
        raise BadInput(f"{folder}: {error}; run that seed again") from error
    except (KeyError, TypeError, AttributeError, ArithmeticError) as error:
        raise BadInput(f"{folder}: damaged: {type(error).__name__} {error}; run that seed again") from error
    return run


def report(runs: list[Run]) -> str:
    """Markdown."""
    from tools.evaluate.figures import binomial, poisson, table  # they need scipy, which `rover` itself does without

    count = len(runs)

    def share(hit: Any) -> str:
        hits = sum(bool(hit(run)) for run in runs)
        return f"{hits} of {count}: {binomial(hits, count)}"

    total = {key: sum(run.summary[key] or 0 for run in runs) for key in ("collisions", "bumper_contacts")}
    surveyed = sum(run.summary["surveyed_m2"] for run in runs)
    area = sum(run.summary["area_m2"] for run in runs)
    mines = [run.summary["mines"] for run in runs]
    fair, found = (sum(row[key] for row in mines) for key in ("with_contrast", "with_contrast_found"))
    rows = [
        [f"missions with a wheel over a mine of at least {FAIR_CONTRAST_K} K", share(lambda run: run.over_mine)],
        ["missions with a collision (harder than 0.1 m/s)", share(lambda run: run.summary["collisions"])],
        ["missions with a bumper contact", share(lambda run: run.summary["bumper_contacts"])],
        ["missions with a wheel in a keep-out zone", share(lambda run: run.summary["keepout_violations"])],
        ["missions with wheels on unseen ground", share(lambda run: run.summary["unseen_ground_m2"])],
        ["missions that ended otherwise than `done`", share(lambda run: run.summary["status"] != "done")],
        ["collisions, bumper contacts", f"{total['collisions']}, {total['bumper_contacts']}"],
        [f"mines of at least {FAIR_CONTRAST_K} K reported", f"{found} of {fair}: {binomial(found, fair)}"],
        ["false indications per m²", poisson(sum(row["false"] for row in mines), area)],
        ["surveyed, share of the area", f"{surveyed / area:.3f}"],
        ["ground under the wheels per m² surveyed", f"{sum(run.fresh for run in runs) / surveyed:.4f} m²"],
        ["duration, median and mean", f"{median(d := [r.summary['duration_s'] for r in runs]):.0f} s, {mean(d):.0f} s"],
        ["way, median", f"{median(run.summary['distance_m'] for run in runs):.1f} m"],
    ]
    return table(["of all missions", "counted, share, 95 % interval"], rows)


def main(arguments: list[str]) -> int:
    """Prints the table; 1 when a mission has left no result."""
    parser = argparse.ArgumentParser(prog="python -m tools.bench campaign", description=__doc__)
    parser.add_argument("folder", type=Path)
    options = parser.parse_args(arguments)
    named = [folder for folder in options.folder.glob("seed-*") if folder.name.removeprefix("seed-").isdigit()]
    folders = sorted(named, key=lambda folder: int(folder.name.removeprefix("seed-")))
    if not folders:
        raise BadInput(f"{options.folder}: no seed-N in it; make some with python -m tools.bench missions --out")
    runs = {folder.name: read_run(folder) for folder in folders}
    there = [run for run in runs.values() if run is not None]
    missing = [name for name, run in runs.items() if run is None]
    print(f"Seeds {folders[0].name.removeprefix('seed-')} to {folders[-1].name.removeprefix('seed-')}.\n")
    print(report(there) if there else "no mission has left a result")
    if missing:
        print(f"\nwithout a result: {', '.join(missing)}")
    return 1 if missing else 0
