"""How well anybody could tell a buried mine from bare soil: the best linear observer, who knows where to look.

    python -m tools.evaluate.limit --fields 40

The soil's own texture hides weak mines, whatever looks at it. Patches of ground without anything give the covariance
of texture, sensor noise and optics; the mine's simulated profile is the signal. d' is the distance between both in
units of the noise after the filter that is best for exactly this depth, hour and place: a detector that has to search,
in ground that is not Gaussian, does not reach it.
"""

from __future__ import annotations

import argparse
import math

import cv2
import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.progress import track
from rover.detection.classifier import CLASSES
from rover.detection.ground.image import GroundRectifier
from rover.detection.ground.patch import SIDE as PATCH_SIDE
from rover.detection.ground.patch import STATISTICS
from rover.vision.camera.file import load_camera
from rover.vision.camera.model import CameraModel
from rover_hil.ground import daily_contrasts

from tools.evaluate.figures import table
from tools.train.ground.fields import make_field, views
from tools.train.ground.look import in_view, truth_of
from tools.train.ground.samples import Looks
from tools.train.ground.train import FIRST_SOIL_TEST, HELD_OUT_SOIL, MIN_TESTED_KELVIN, SOIL_TEST_FIELDS, TEST_FRAMES

# Patches of so many pixels of 2 cm.
SIDE, STEP = 22, 0.02
SPOTS = 60
# Bare ground: metres to mines and obstacles.
FROM_MINE, FROM_OBSTACLE = 0.42, 0.35
DEPTHS, HOUR = (0.01, 0.02, 0.03, 0.05, 0.07), 14.9
FLOOR = MIN_TESTED_KELVIN
# Places of a look that could be taken for a mine: a square metre holds some thirty of a mine's size.
PLACES = (10, 30)
CONTRASTS = (0.5, 0.65, 0.8, 1.0, 1.25, 1.6)
STRENGTH = 3 * PATCH_SIDE**2 + STATISTICS.index("strength")
BURIED = CLASSES.index("buried")
_OFFSETS = (np.arange(SIDE) - (SIDE - 1) / 2.0) * STEP


def look_at_tests(camera: CameraModel, fields: int) -> tuple[NDArray[np.float64], NDArray[np.float64], int]:
    """Patches (N, SIDE²) in kelvin of ground that holds nothing, from looks at the test fields.

    Then the buried mines of at least FLOOR kelvin in view of these looks, (M, 2) depth and contrast, and the number
    of looks.
    """
    rectifier, patches, rng = GroundRectifier(camera), [], np.random.default_rng(0)
    mines, looks = [], 0
    seeds = range(FIRST_SOIL_TEST, FIRST_SOIL_TEST + fields)
    for seed in track(seeds, "fields for the limit", console=Console(stderr=True)):
        field = make_field(camera, HELD_OUT_SOIL, seed, None, True)
        if field is None:
            continue
        for pose, frame in views(field, camera, TEST_FRAMES, seed):
            image = rectifier.rectify(frame)
            looks += 1
            seen = [field.ground.mines[number] for number in in_view(image, pose, field.ground, camera)]
            mines += [(m.depth, abs(m.contrast_k)) for m in seen if m.kind == "buried" and abs(m.contrast_k) >= FLOOR]
            soft = np.asarray(cv2.blur(image.kelvin, (2, 2)), np.float32)
            reach, (rows, columns) = int(0.5 * SIDE * STEP / image.metres_per_pixel), soft.shape
            corners = [(r, c) for r in (-reach, reach) for c in (-reach, reach)]
            spots = np.column_stack(
                (rng.uniform(reach, rows - reach - 1, SPOTS), rng.uniform(reach, columns - reach - 1, SPOTS))
            )
            truth = truth_of(image.to_base(spots), pose, field.ground, camera)
            bare = (truth.to_mine > FROM_MINE) & (truth.to_obstacle > FROM_OBSTACLE)
            for row, column in spots[bare].tolist():
                if all(image.valid[int(row) + r, int(column) + c] for r, c in corners):
                    patches.append(_cut(soft, row, column, STEP / image.metres_per_pixel))
    return np.array(patches, np.float64), np.array(mines), looks


def _cut(picture: NDArray[np.float32], row: float, column: float, step: float) -> NDArray[np.float32]:
    offsets = ((_OFFSETS / STEP) * step).astype(np.float32)
    down, across = np.meshgrid(row + offsets, column + offsets, indexing="ij")
    patch = cv2.remap(picture, across.astype(np.float32), down.astype(np.float32), cv2.INTER_LINEAR)
    return np.asarray(patch, np.float32).ravel()


def separation(patches: NDArray[np.float64], profile: NDArray[np.float64]) -> float:
    """d' of a signal (SIDE²,) in kelvin in such ground; the patches' means are not used."""
    plain = patches - patches.mean(axis=1, keepdims=True)
    covariance = np.cov(plain.T) + 1e-3 * np.eye(SIDE * SIDE)
    signal = profile - profile.mean()
    return float(np.sqrt(signal @ np.linalg.solve(covariance, signal)))


def best_f1(distances: NDArray[np.float64], looks: int, places: int) -> float:
    """The best F1 over all thresholds for mines at these d', with so many places a look that hold nothing."""
    thresholds = np.linspace(0.0, 8.0, 401)
    hits = np.array([_above(t - distances).sum() for t in thresholds])
    false = looks * places * _above(thresholds)
    return float((2.0 * hits / (hits + false + len(distances))).max())


def searching_f1(looks: Looks) -> float:
    """The best F1 on buried mines of at least FLOOR kelvin for who calls every strong candidate a buried mine.

    Surface mines and obstacles are told to him: they are no false alarms.
    """
    strength = looks.vectors[:, STRENGTH].astype(np.float64)
    best: dict[tuple[int, int], float] = {}
    for index in np.flatnonzero(looks.on_mine).tolist():
        key = int(looks.look[index]), int(looks.mine[index])
        best[key] = max(best.get(key, 0.0), float(strength[index]))
    mines = np.array(
        [
            best.get((int(look), int(mine)), 0.0)
            for look, mine, kind, contrast in looks.seen.tolist()
            if int(kind) == BURIED and contrast >= FLOOR
        ]
    )
    ground = strength[looks.on_ground]
    thresholds = np.quantile(np.concatenate((mines, ground)), np.linspace(0.0, 1.0, 400))
    hits = np.array([(mines > t).sum() for t in thresholds])
    called = hits + np.array([(ground > t).sum() for t in thresholds])
    return float((2.0 * hits / np.maximum(called + len(mines), 1)).max())


def _above(z: NDArray[np.float64] | float) -> NDArray[np.float64]:
    """Share of a normal distribution above z."""
    return np.asarray(0.5 * np.vectorize(math.erfc)(np.asarray(z) / math.sqrt(2.0)))


def report(fields: int) -> str:
    """Markdown: the best F1 on the buried mines of so many test fields, and d' by depth and contrast."""
    patches, mines, looks = look_at_tests(load_camera("lepton-160"), fields)
    distance = np.hypot(*np.meshgrid(_OFFSETS, _OFFSETS)).ravel()
    day = daily_contrasts(HELD_OUT_SOIL[0], DEPTHS)
    rows, known = [], []
    for depth in DEPTHS:
        profile = day.profile(depth, HOUR, distance) / day.profile(depth, HOUR, 0.0)
        known.append(separation(patches, profile))
        rows.append([f"{100 * depth:g} cm", *(f"{known[-1] * contrast:.1f}" for contrast in CONTRASTS)])
    distances = np.interp(mines[:, 0], DEPTHS, known) * mines[:, 1]
    best = ", ".join(f"{best_f1(distances, looks, places):.2f} with {places}" for places in PLACES)
    told = table(["depth \\ contrast", *(f"{contrast:g} K" for contrast in CONTRASTS)], rows)
    return (
        f"{len(patches)} patches of bare ground, {len(mines)} buried mines of at least {FLOOR:g} K in {looks} looks:\n"
        f"best F1 {best} places a look to confuse them with.\n\n{told}"
    )


def main() -> None:
    """Prints the report."""
    parser = argparse.ArgumentParser(prog="python -m tools.evaluate.limit", description=__doc__.split("\n")[0])
    parser.add_argument("--fields", type=int, default=SOIL_TEST_FIELDS)
    print(report(parser.parse_args().fields))


if __name__ == "__main__":
    main()
