"""How well the rover knows where it is in each unfriendly world: every effect alone as in a mix, and the mixes.

    python -m tools.bench unfriendly --seeds 3 --first 7100
    python -m tools.bench unfriendly --seeds 3 --first 7100 --mix brutal --only camera.lens,camera.mount

A scripted drive of 63 s over an empty field, on the plant, through the localizer of the mission: a turn, ways and turns
between. Errors are of the pose in map, against the truth; the stated bound is the ellipse of 95 %.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from rover.capture.frame import Frame
from rover.mission.checks import Checks
from rover.mission.config import Mission, load
from rover.vision.camera.file import load_camera
from rover.vision.localization.localizer import Localizer
from rover_hil.ground import build
from rover_hil.plant_config import build_plant
from rover_hil.world.file import World, find_world, load_world

MIXES = ("mild", "hard", "brutal")
# Chi-square of two degrees of freedom, 95 %.
BOUND = 5.991
START_SIGMA = (0.005, 0.005, 0.0087)
# Seconds and duties: a whole turn first, as a mission begins.
DRIVE = (
    *((1.0, 0.0, 0.0), (14.0, -0.14, 0.14), (2.0, 0.0, 0.0), (3.0, 0.3, 0.3), (7.0, -0.14, 0.14), (1.0, 0.0, 0.0)),
    *((4.0, 0.3, 0.3), (9.0, 0.14, -0.14), (3.0, 0.3, 0.3), (7.0, -0.14, 0.14), (3.0, 0.3, 0.3), (8.0, 0.14, -0.14)),
    (4.0, 0.3, 0.3),
)
CYCLE_MS = 20


@dataclass(frozen=True)
class Driven:
    """One drive. errors (n,): metres; inside: share of samples in the stated bound; refused: share of pictures."""

    errors: np.ndarray
    sigmas: np.ndarray
    inside: float
    refused: float
    told: tuple[str, ...]


def drive(world: World, seed: int) -> Driven:
    """The scripted drive in that world."""
    mission = load("demo")
    launch = replace(mission.launch, pose=replace(mission.launch.pose, x=1.5, y=1.5, heading=0.3))
    with TemporaryDirectory(prefix="rover-world-") as folder:
        file = Path(folder) / "world.toml"
        file.write_text(world.text(), encoding="utf-8")
        field = replace(mission.field, rocks=0, grass=0, world=str(file))
        return _driven(replace(mission, field=field, launch=launch), seed)


def _driven(mission: Mission, seed: int) -> Driven:
    camera, vehicle = load_camera(mission.rover.camera), mission.rover.vehicle
    plant = build_plant(mission, build(mission, seed), camera, seed)
    localizer, checks = Localizer(camera, mission.launch.pose, START_SIGMA), Checks()
    scale = 2.0 * math.pi * vehicle.wheel_radius / vehicle.counts_per_revolution
    before, rows, pictures, refused, told = np.array(plant.encoders()), [], 0, 0, set()
    for seconds, left, right in DRIVE:
        for _ in range(round(seconds * 1e3 / CYCLE_MS)):
            for _ in range(CYCLE_MS):
                plant.step(left, right, True)
            now, counts = plant.now_us * 1e-6, np.array(plant.encoders())
            localizer.predict(now, *((counts - before) * scale).tolist())
            before = counts
            judged = None
            for sequence, exposed, _, ffc, pixels in plant.take_frames():
                picture = np.frombuffer(pixels, "<u2").reshape(camera.height, camera.width).astype(np.uint16)
                fix = localizer.observe(Frame(picture, exposed * 1e-6, sequence, ffc))
                pictures, refused = pictures + (not ffc), refused + (not ffc and not fix.accepted)
                judged = judged if ffc else fix
            checks.take(now, (), judged)
            told |= {str(check) for check in checks.active}
            x, y, _ = plant.pose()
            off = np.array([localizer.pose.x - x, localizer.pose.y - y])
            covariance = localizer.covariance[:2, :2]
            rows.append((*off, float(off @ np.linalg.solve(covariance, off)), math.sqrt(covariance.trace())))
    found = np.array(rows)
    errors = np.hypot(found[:, 0], found[:, 1])
    inside = float(np.mean(found[:, 2] < BOUND))
    return Driven(errors, found[:, 3], inside, refused / max(pictures, 1), tuple(sorted(told)))


def row(name: str, runs: Sequence[Driven]) -> str:
    """One line of the table."""
    errors, sigmas = np.concatenate([run.errors for run in runs]), np.concatenate([run.sigmas for run in runs])
    over = errors / sigmas
    told = sorted({check for run in runs for check in run.told})
    noticed = ", ".join(f"{check} {sum(check in run.told for run in runs)}/{len(runs)}" for check in told) or "–"
    return (
        f"| {name} | {len(runs)} | {100 * np.median(errors):.1f} | {100 * np.percentile(errors, 95):.1f} "
        f"| {np.median(over):.2f} | {np.percentile(over, 95):.2f} | {100 * np.mean([run.inside for run in runs]):.0f} "
        f"| {100 * np.mean([run.refused for run in runs]):.1f} | {noticed} |"
    )


def main(arguments: list[str]) -> int:
    """Drives and prints the table, line by line."""
    parser = argparse.ArgumentParser(prog="python -m tools.bench unfriendly", description=__doc__)
    parser.add_argument("--seeds", type=int, default=3, help="drives in each world, seeds from --first on")
    parser.add_argument("--first", type=int, default=7100)
    parser.add_argument("--mix", choices=MIXES, default="hard", help="whose sizes each effect alone has")
    parser.add_argument("--only", default="", help="effects and mixes, separated by commas; all when left out")
    options = parser.parse_args(arguments)
    mix = load_world(find_world(options.mix))
    worlds = {"friendly": World()}
    worlds |= {name: mix.alone(name) for name in mix.effects}
    worlds |= {name: load_world(find_world(name)) for name in MIXES}
    print(
        "| world | drives | error, median cm | 95 % cm | over σ, median | 95 % | inside the 95 % bound, % of samples "
        "| pictures refused, % | who noticed |\n|---|--:|--:|--:|--:|--:|--:|--:|---|"
    )
    for name, world in worlds.items():
        if not options.only or name in options.only.split(","):
            runs = [drive(world, seed) for seed in range(options.first, options.first + options.seeds)]
            print(row(name, runs), flush=True)
    return 0
