"""A detector driven over simulated fields along lanes: which mines does it report, and what else?

    python -m tools.bench detector --fields 24 --first 4000
    python -m tools.bench detector --fields 24 --first 4000 --mixed     # other soils and hours, by day and night

Poses are nearly exact (1 cm, 10 mrad): this measures detection and fusion, not localization. Mines that have no
contrast, or that an obstacle hides, count as missed in their class of contrast.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.progress import track
from rover.detection.classifier import Classifier, default_model
from rover.detection.evidence_settings import EvidenceSettings
from rover.detection.fusion import Evidence
from rover.detection.ground.detect import DetectSettings, detect
from rover.detection.ground.image import GroundRectifier
from rover.detection.place import Place
from rover.errors import BadInput
from rover.geometry import Pose2
from rover.mission import config
from rover.vision.camera.file import load_camera
from rover.vision.camera.model import CameraModel
from rover_hil.ground import Ground, Mine, build
from rover_hil.plant_config import build_plant
from rover_hil.referee import FAIR_CONTRAST_K, FOUND_WITHIN_M

from tools.train.ground.fields import Field, draw_pattern, expose

# Classes of contrast at the surface, kelvin.
CLASSES = ((0.0, 0.25), (0.25, 0.5), (0.5, 0.8), (0.8, 1.2), (1.2, math.inf))
THRESHOLDS = (0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9)
HOURS = (13, 10, 15, 12, 14, 11, 16, 21, 3)
SOILS = ("loam", "clay", "dry-sand", "moist-clay")
LANE, STEP, TURN = 0.55, 0.06, 0.2
POSE_SIGMA, HEADING_SIGMA = 0.01, 0.01


@dataclass(frozen=True, eq=False)
class Driven:
    """One field and the places at its end; seconds are processor time of detection and fusion."""

    ground: Ground
    places: list[Place]
    frames: int
    seconds: float


def lanes(ground: Ground) -> Iterator[Pose2]:
    """Poses along lanes to and fro, turning at each end; none inside an obstacle."""
    width, length = ground.area
    for number, y in enumerate(np.arange(0.3, length, LANE).tolist()):
        xs = np.arange(0.15, width - 0.15, STEP)[:: 1 if number % 2 == 0 else -1].tolist()
        heading = 0.0 if number % 2 == 0 else math.pi
        poses = [Pose2(x, y, heading) for x in xs]
        poses += [Pose2(xs[-1], y, heading + turn) for turn in np.arange(0.0, math.pi, TURN).tolist()]
        for pose in poses:
            if all(math.hypot(pose.x - x, pose.y - y) >= r + 0.17 for x, y, r, _ in ground.obstacles.tolist()):
                yield pose


def drive(
    camera: CameraModel, classifier: Classifier, seed: int, mixed: bool, data: Path | None = None
) -> Driven | None:
    """Drives over the demo mission's field of this seed, laid with real pictures where `data` holds them; None when it
    does not fit."""
    rng = np.random.default_rng([seed, 5])
    mission = config.load("demo")
    if mixed:
        soil, hour = SOILS[seed % len(SOILS)], HOURS[seed % len(HOURS)]
        mission = replace(mission, time_of_day_s=hour * 3600.0, field=replace(mission.field, soil=soil))
    try:
        ground = build(mission, seed, data)
    except BadInput:
        return None
    field = Field(ground, build_plant(mission, ground, camera, seed))
    pattern = draw_pattern(camera, rng)
    rectifier, evidence = GroundRectifier(camera), Evidence(EvidenceSettings())
    covariance = np.diag([POSE_SIGMA**2, POSE_SIGMA**2, HEADING_SIGMA**2])
    frames, seconds = 0, 0.0
    for pose in lanes(ground):
        frame = expose(field, camera, pose, pattern, rng)
        dx, dy, turn = rng.normal(0.0, (POSE_SIGMA, POSE_SIGMA, HEADING_SIGMA)).tolist()
        believed = Pose2(pose.x + dx, pose.y + dy, pose.heading + turn)
        begun = time.thread_time()
        detections = detect(rectifier.rectify(frame), classifier, DetectSettings())
        evidence.update(detections, believed, covariance, 0.24 * frames)
        seconds += time.thread_time() - begun
        frames += 1
    return Driven(ground, evidence.places, frames, seconds)


def drive_all(model: str | Path, fields: int, first: int, mixed: bool, data: Path | None = None) -> list[Driven]:
    """Drives over `fields` fields with seeds from `first`; those that cannot be laid are left out.

    Progress on stderr.
    """
    camera, classifier = load_camera("lepton-160"), Classifier(model)
    seeds = track(range(first, first + fields), "fields driven over", console=Console(stderr=True))
    runs = [drive(camera, classifier, seed, mixed, data) for seed in seeds]
    return [run for run in runs if run is not None]


def reports(driven: Driven, threshold: float) -> list[Place]:
    """Indications inside the area at another threshold."""
    width, length = driven.ground.area
    views = EvidenceSettings().report_views
    return [
        p
        for p in driven.places
        if p.views >= views and p.mine_probability >= threshold and 0 <= p.x <= width and 0 <= p.y <= length
    ]


def suspects(driven: Driven) -> list[Place]:
    """Suspected places inside the area."""
    width, length = driven.ground.area
    return [p for p in driven.places if p.suspected and 0 <= p.x <= width and 0 <= p.y <= length]


def is_found(mine: Mine, places: list[Place]) -> bool:
    """True when one of the places lies within FOUND_WITHIN_M of the mine."""
    return any(math.hypot(p.x - mine.x, p.y - mine.y) <= FOUND_WITHIN_M for p in places)


def false_of(driven: Driven, places: list[Place]) -> int:
    """Places that lie outside every mine's halo: its half-extent and FOUND_WITHIN_M more."""
    mines = driven.ground.mines
    return sum(all(math.hypot(p.x - m.x, p.y - m.y) > m.radius + FOUND_WITHIN_M for m in mines) for p in places)


def as_markdown(runs: list[Driven]) -> str:
    """By threshold and by contrast."""
    chosen = EvidenceSettings().report_threshold
    area = sum(r.ground.area[0] * r.ground.area[1] for r in runs)
    pairs = [(r, m) for r in runs for m in r.ground.mines]
    visible = [(r, m) for r, m in pairs if abs(m.contrast_k) >= FAIR_CONTRAST_K]
    lines = [f"| report threshold | mines >= {FAIR_CONTRAST_K} K found | false | false per m² |", "|---|---|---|---|"]
    for threshold in THRESHOLDS:
        at = {id(r): reports(r, threshold) for r in runs}
        found = sum(is_found(m, at[id(r)]) for r, m in visible)
        false = sum(false_of(r, at[id(r)]) for r in runs)
        share = f"{found / max(len(visible), 1):.1%}"
        lines.append(f"| {threshold} | {found} of {len(visible)} ({share}) | {false} | {false / area:.3f} |")
    lines += ["", f"| contrast, K | mines | found at {chosen} |", "|---|---|---|"]
    at = {id(r): reports(r, chosen) for r in runs}
    for low, high in CLASSES:
        some = [(r, m) for r, m in pairs if low <= abs(m.contrast_k) < high]
        found = sum(is_found(m, at[id(r)]) for r, m in some)
        lines.append(f"| {low:g} to {high:g} | {len(some)} | {found} |")
    found_at = [min(math.hypot(p.x - m.x, p.y - m.y) for p in at[id(r)]) for r, m in visible if is_found(m, at[id(r)])]
    median, most = np.percentile(found_at, [50, 95]) * 100.0 if found_at else (math.nan, math.nan)
    extra = sum(false_of(r, suspects(r)) for r in runs) / len(runs)
    rate = 1e3 * sum(r.seconds for r in runs) / sum(r.frames for r in runs)
    lines += [
        "",
        f"{len(runs)} fields, {area:.0f} m². Position error {median:.1f} cm (median), {most:.1f} cm (95 %). Suspected "
        f"places at the end that are no mines: {extra:.1f} per field. Detection and fusion take {rate:.1f} ms of "
        "processor time a frame.",
    ]
    return "\n".join(lines)


def main(arguments: list[str]) -> int:
    """Drives over the fields and prints the tables."""
    parser = argparse.ArgumentParser(prog="python -m tools.bench detector", description=__doc__.split("\n")[0])
    parser.add_argument("--fields", type=int, default=20)
    parser.add_argument("--first", type=int, default=4000, help="seed of the first field")
    parser.add_argument("--mixed", action="store_true", help="other soils and hours than the demo's")
    parser.add_argument("--model", default=default_model())
    options = parser.parse_args(arguments)
    print(as_markdown(drive_all(options.model, options.fields, options.first, options.mixed)))
    return 0
