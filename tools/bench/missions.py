"""Many whole missions on the simulated rig, one seed each: is what the rover reports true, and is it careful?

python -m tools.bench missions --seeds 20
python -m tools.bench missions --seeds 20 --data DIR     # ground laid from real thermal pictures
python -m tools.bench missions --size 6x8 --seeds 5      # fields of 6 x 8 m, launched from a corner
"""

from __future__ import annotations

import argparse
import json
import math
import os
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any

from rover_hil.referee import FAIR_CONTRAST_K, FOUND_WITHIN_M

# Time that a mission may take, seconds per square metre: demo fields take 12 to 18.
SECONDS_PER_M2 = 40.0
MINE_CLASSES = ("surface", "buried")


@dataclass(frozen=True)
class Outcome:
    """What one mission came to; lengths in metres, times in seconds."""

    seed: int
    status: str
    reason: str
    duration: float
    wall: float
    distance: float
    visible: int
    found: int
    mines: int
    found_of_all: int
    false_indications: int
    area: float
    collisions: int
    keepout_violations: int
    unseen_ground: float
    wheel_over_mine: int
    ate: float
    odometry_ate: float
    coverage: float
    relative_rmse: float | None
    inside_95: float | None
    processor: float


def judge(summary: dict[str, Any], truth: dict[str, Any], wall: float, processor: float) -> Outcome:
    """Compares a run's summary with what really lay in the field; wall, processor: seconds that the run took.

    An indication is false here when it lies outside every mine's halo: its radius and FOUND_WITHIN_M beyond.
    """
    reports = [d for d in summary["detections"] if d["class"] in MINE_CLASSES]
    mines = truth["mines"]

    def found(mine: dict[str, Any]) -> bool:
        return any(math.hypot(d["x"] - mine["x"], d["y"] - mine["y"]) <= FOUND_WITHIN_M for d in reports)

    def false(report: dict[str, Any]) -> bool:
        return all(
            math.hypot(report["x"] - mine["x"], report["y"] - mine["y"]) > mine["radius"] + FOUND_WITHIN_M
            for mine in mines
        )

    visible = [mine for mine in mines if abs(mine["contrast_k"]) >= FAIR_CONTRAST_K]
    localization = summary["localization"]
    return Outcome(
        seed=summary["seed"],
        status=summary["status"],
        reason=summary.get("reason", ""),
        duration=summary["duration_s"],
        wall=wall,
        distance=summary["distance_m"],
        visible=len(visible),
        found=sum(found(mine) for mine in visible),
        mines=len(mines),
        found_of_all=sum(found(mine) for mine in mines),
        false_indications=sum(false(report) for report in reports),
        area=truth["area"]["width"] * truth["area"]["height"],
        collisions=summary["collisions"],
        keepout_violations=summary["keepout_violations"],
        unseen_ground=summary["unseen_ground_m2"],
        wheel_over_mine=summary["wheel_over_mine"],
        ate=localization["ate_rmse_m"],
        odometry_ate=localization["odometry_only_ate_rmse_m"],
        coverage=summary["coverage"],
        relative_rmse=localization["relative_rmse_m"],
        inside_95=localization["inside_95"],
        processor=processor,
    )


def mission_of_size(size: str, out: Path) -> str:
    """A mission file over a field of `WIDTHxHEIGHT` metres with all defaults; its path. Raises ValueError."""
    width, height = (float(side) for side in size.split("x"))
    out.mkdir(parents=True, exist_ok=True)
    file = out / f"field-{size}.toml"
    limit = max(SECONDS_PER_M2 * width * height, 1200.0)
    file.write_text(
        f'[mission]\nname = "{size}"\nmax_duration_s = {limit:g}\n'
        f"[area]\nwidth_m = {width:g}\nheight_m = {height:g}\n"
        "[launch]\nx_m = 0.5\ny_m = 0.5\nheading_deg = 45.0\n"
    )
    return str(file)


def run_one(mission: str, seed: int, out: Path, data: str | None, rover: str) -> Outcome | str:
    """Runs one mission in a process of its own; a line of text says why there is no outcome."""
    command = [rover, "run", mission, "--rig", "sitl", "--seed", str(seed), "--out", str(out), "--force"]
    command += ["--json", "--quiet"]
    if data:
        command += ["--data", data]
    begin = time.monotonic()
    out.mkdir(parents=True, exist_ok=True)
    with (out.parent / f"{out.name}.log").open("w+") as told:
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=told)
        _, status, used = os.wait4(process.pid, 0)
        told.seek(0)
        last = (told.read().strip().splitlines() or ["no output"])[-1]
    wall = time.monotonic() - begin
    try:
        summary = json.loads((out / "summary.json").read_text())
        truth = json.loads((out / "truth.json").read_text())
    except (OSError, ValueError):
        return f"seed {seed}: exit code {os.waitstatus_to_exitcode(status)}, no result: {last}"
    return judge(summary, truth, wall, used.ru_utime + used.ru_stime)


def table(outcomes: list[Outcome]) -> str:
    """The outcomes as a Markdown table with a closing line of totals."""
    lines = [
        "| seed | status | coverage % | driven m | mission s | × real time | processor s per s | mines ≥ 0.5 K found "
        "| all mines found | false | collisions | keep-out | unseen m² | wheel over mine | ATE cm | wheels alone cm "
        "| among things cm | inside 95 % |",
        "|--:|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|",
    ]
    for o in outcomes:
        lines.append(
            f"| {o.seed} | {o.status} | {100 * o.coverage:.1f} | {o.distance:.1f} | {o.duration:.0f} "
            f"| {o.duration / o.wall:.1f} | {o.processor / o.duration:.2f} | {o.found}/{o.visible} "
            f"| {o.found_of_all}/{o.mines} | {o.false_indications} | {o.collisions} "
            f"| {o.keepout_violations} | {o.unseen_ground:.4f} | {o.wheel_over_mine} | {100 * o.ate:.1f} "
            f"| {100 * o.odometry_ate:.1f} | {_told(o.relative_rmse, '.2f')} | {_told(o.inside_95, '.0f')} |"
        )
    return "\n".join(lines)


def _told(share: float | None, form: str) -> str:
    """Hundred times a figure, or a dash where there is none."""
    return "–" if share is None else f"{100 * share:{form}}"


def totals(outcomes: list[Outcome]) -> str:
    """The sums and worst cases that the project promises."""
    visible = sum(o.visible for o in outcomes)
    found = sum(o.found for o in outcomes)
    statuses = {name: sum(o.status == name for o in outcomes) for name in sorted({o.status for o in outcomes})}
    false = sum(o.false_indications for o in outcomes)
    stated = all(o.reason for o in outcomes if o.status != "done")
    return "\n".join(
        [
            f"- missions: {len(outcomes)}; "
            + ", ".join(f"{n} {name}" for name, n in statuses.items())
            + ("" if stated else " (a reason is missing)"),
            f"- mines with at least {FAIR_CONTRAST_K} K of contrast reported within 10 cm: {found} of {visible} "
            f"({100 * found / max(visible, 1):.1f} %)",
            f"- mines of any contrast: {sum(o.found_of_all for o in outcomes)} of {sum(o.mines for o in outcomes)}",
            f"- false indications per m²: mean {false / sum(o.area for o in outcomes):.3f}, worst "
            f"{max(o.false_indications / o.area for o in outcomes):.3f}",
            f"- collisions {sum(o.collisions for o in outcomes)}, keep-out violations "
            f"{sum(o.keepout_violations for o in outcomes)}, unseen ground driven on "
            f"{sum(o.unseen_ground for o in outcomes):.4f} m², wheel over a mine "
            f"{sum(o.wheel_over_mine for o in outcomes)}",
            f"- trajectory error: median {100 * median(o.ate for o in outcomes):.1f} cm, worst "
            f"{100 * max(o.ate for o in outcomes):.1f} cm; wheels alone: median "
            f"{100 * median(o.odometry_ate for o in outcomes):.1f} cm, worst "
            f"{100 * max(o.odometry_ate for o in outcomes):.1f} cm",
            f"- speed (process start to report): median {median(o.duration / o.wall for o in outcomes):.1f} × "
            f"real time, slowest {min(o.duration / o.wall for o in outcomes):.1f} ×",
        ]
    )


def main(arguments: list[str]) -> int:
    """Runs the missions and prints the tables; 1 when a mission gave no result."""
    parser = argparse.ArgumentParser(prog="python -m tools.bench missions", description=__doc__)
    parser.add_argument("--mission", default="demo", help="mission file, or the name of one that ships")
    parser.add_argument("--size", default=None, help="WIDTHxHEIGHT of a field in metres, instead of --mission")
    parser.add_argument("--seeds", type=int, default=20, help="how many seeds, from --first on")
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--data", default=None, help="folder with landmines/: real ground texture")
    parser.add_argument("--jobs", type=int, default=1, help="missions at a time (1 gives honest speeds)")
    parser.add_argument("--out", default="runs/bench", type=Path)
    options = parser.parse_args(arguments)
    rover = str(Path(sys.executable).parent / "rover")
    mission = options.mission if options.size is None else mission_of_size(options.size, options.out)

    def one(seed: int) -> Outcome | str:
        outcome = run_one(mission, seed, options.out / f"seed-{seed}", options.data, rover)
        text = outcome if isinstance(outcome, str) else table([outcome]).splitlines()[-1]
        print(text, file=sys.stderr, flush=True)
        return outcome

    with ThreadPoolExecutor(options.jobs) as pool:
        results = list(pool.map(one, range(options.first, options.first + options.seeds)))
    outcomes = [result for result in results if isinstance(result, Outcome)]
    if outcomes:
        print(table(outcomes) + "\n\n" + totals(outcomes))
    for result in results:
        if isinstance(result, str):
            print(result, file=sys.stderr)
    return 0 if len(outcomes) == len(results) else 1
