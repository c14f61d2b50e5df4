"""The drives' tables: errors, NEES, loops, kidnaps."""

from __future__ import annotations

import itertools
import math
from statistics import NormalDist

import numpy as np
from rover.vision.camera.file import load_camera

from tools.bench.vision.drives import FRAME_STEPS, Track, follow, loops, random_drive, scenes
from tools.bench.vision.kidnap import Outcome, kidnap
from tools.bench.vision.way import STEP_M

FREEDOM = 3


def chi_squared(probability: float, freedom: int) -> float:
    """Quantile of the χ² distribution after Wilson and Hilferty (1931), good to 0.5 % from 12 degrees of freedom on."""
    spread = 2.0 / (9.0 * freedom)
    return freedom * (1.0 - spread + NormalDist().inv_cdf(probability) * math.sqrt(spread)) ** 3


def nees_text(tracks: list[Track]) -> str:
    """Mean NEES, its 95 % bounds for so many independent runs, and the share of moments at which it lies within."""
    shortest = min(len(track.nees) for track in tracks)
    by_time = np.mean([track.nees[:shortest] for track in tracks], axis=0)
    low, high = (chi_squared(q, FREEDOM * len(tracks)) / len(tracks) for q in (0.025, 0.975))
    within = float(np.mean((by_time >= low) & (by_time <= high)))
    below = float(np.mean(by_time < low))
    return f"{by_time.mean():.2f} ({low:.2f} to {high:.2f}; {within:.0%} of the time within, {below:.0%} below)"


def drive_table(camera_name: str, count: int, first: int, slip: float, length: float, kidnaps: int) -> str:
    """Fused, frames alone and wheels alone over `count` drives; then kidnaps at the end of each."""
    camera = load_camera(camera_name)
    runs, known, unknown = [], [], []
    for _, at in scenes(camera, count, first):
        drive = random_drive(at, slip, length)
        runs.append(follow(at, drive))
        step = len(drive.poses) + FRAME_STEPS
        outcome, step = kidnap(at, drive, runs[-1].localizer, kidnaps, True, step)
        known.append(outcome)
        unknown.append(kidnap(at, drive, runs[-1].localizer, kidnaps // 2, False, step)[0])
    lines = [
        "| | position, cm RMS: each drive | all | heading, ° RMS | unless lost | NEES (95 % bounds) | frames refused "
        "| lost |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for name, tracks in (
        ("wheels and frames", [run.fused for run in runs]),
        ("frames alone", [run.frames for run in runs]),
        ("wheels alone", [run.wheels for run in runs]),
    ):
        each = [track.rms_m() * 100.0 for track in tracks]
        whole = float(np.sqrt(np.mean(np.square(each))))
        turned = float(np.sqrt(np.mean([track.heading_deg() ** 2 for track in tracks])))
        placed = float(np.sqrt(np.mean([track.heading_deg_placed() ** 2 for track in tracks])))
        lost = str(sum(sum(track.lost) for track in tracks)) if tracks[0].nees else "–"
        frames = sum(len(track.errors) for track in tracks)
        nees = nees_text(tracks) if tracks[0].nees else "–"
        refused = f"{sum(track.refused for track in tracks)} of {frames}" if tracks[0].nees else "–"
        text = " ".join(f"{value:.1f}" for value in each)
        lines.append(f"| {name} | {text} | {whole:.1f} | {turned:.2f} | {placed:.2f} | {nees} | {refused} | {lost} |")
    lines += ["", "| kidnapped to | tries | found within 3 frames | later | lost, and says so | wrong | not noticed |",
              "|---|---|---|---|---|---|---|"]  # fmt: skip
    lines += [_kidnap_row("ground that it knows", known), _kidnap_row("ground that it has not seen", unknown)]
    return "\n".join(lines)


def _kidnap_row(name: str, outcomes: list[Outcome]) -> str:
    frames = list(itertools.chain.from_iterable(outcome.frames for outcome in outcomes))
    soon = sum(count <= 3 for count in frames)
    lost, wrong, unnoticed = (sum(getattr(o, kind) for o in outcomes) for kind in ("lost", "wrong", "unnoticed"))
    tried = sum(outcome.tried for outcome in outcomes)
    return f"| {name} | {tried} | {soon} | {len(frames) - soon} | {lost} | {wrong} | {unnoticed} |"


def loop_table(camera_name: str, count: int, first: int, slip: float, times: int) -> str:
    """Fused error loop by loop over `count` fields."""
    camera = load_camera(camera_name)
    rows = []
    for _, at in scenes(camera, count, first):
        drive, steps = loops(at, slip, times)
        run = follow(at, drive, frames_alone=False)
        frames = max(1, len(run.fused.errors) // times)
        rms = [run.fused.rms_m(k * frames, (k + 1) * frames) * 100.0 for k in range(times)]
        wheels = run.wheels.rms_m(-frames) * 100.0
        metres = sum(a.distance(b) for a, b in itertools.pairwise(drive.poses)) / times
        seconds = steps * STEP_M
        rows.append(
            f"| {metres:.1f} m, {seconds:.0f} s | " + " | ".join(f"{v:.1f}" for v in rms) + f" | {wheels:.0f} |"
        )
    head = "| loop of | " + " | ".join(str(k + 1) for k in range(times)) + " | wheels alone in the last |"
    return "\n".join([head, "|---|" + "---|" * (times + 1), *rows])
