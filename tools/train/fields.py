"""Synthetic fields to learn from, drawn from a seed, and frames of them from poses that show things."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rover.capture.frame import Frame
from rover.errors import BadInput
from rover.geometry import Pose2
from rover.mission import config
from rover.vision.camera import CameraModel
from rover_hil.ground import Ground, build
from rover_hil.plant_config import build_plant
from rover_plant import Plant

# What the simulated sensor adds, standard deviations in kelvin, as the plant's camera does.
NETD = 0.05
ROW_PATTERN = 0.03
COLUMN_PATTERN = 0.04
PIXEL_PATTERN = 0.03
VIGNETTING = 0.4
DEPTHS = (0.005, 0.01, 0.02, 0.03, 0.05, 0.05, 0.07)


@dataclass(frozen=True, eq=False)
class Field:
    """One ground and the plant that renders it."""

    ground: Ground
    plant: Plant


def make_field(camera: CameraModel, soils: tuple[str, ...], seed: int, data: Path | None = None) -> Field | None:
    """A 3 x 4 m field drawn from the seed; None for a draw too full to place. `data`: real texture from there."""
    rng = np.random.default_rng([seed, 77])
    base = config.load("demo")
    settings = replace(
        base.field,
        soil=str(rng.choice(soils)),
        rocks=int(rng.integers(2, 6)),
        grass=int(rng.integers(2, 5)),
        surface_mines=int(rng.integers(3, 5)),
        buried_mine_depths=tuple(sorted(float(rng.choice(DEPTHS)) for _ in range(rng.integers(4, 7)))),
    )
    mission = replace(base, time_of_day_s=float(rng.uniform(0.0, 86_400.0)), field=settings)
    try:
        ground = build(mission, seed, data)
    except BadInput:
        return None
    return Field(ground, build_plant(mission, ground, camera, seed))


def random_pose(ground: Ground, rng: np.random.Generator) -> Pose2:
    """A pose in the area, mostly one with a mine or an obstacle in view."""
    width, height = ground.area
    things = 3 * [(m.x, m.y) for m in ground.mines] + [(x, y) for x, y, _, _ in ground.obstacles.tolist()]
    for _ in range(50):
        if things and rng.random() < 0.8:
            x, y = things[int(rng.integers(len(things)))]
            reach, bearing, heading = rng.uniform(0.3, 1.1), rng.uniform(-0.45, 0.45), rng.uniform(-math.pi, math.pi)
            pose = Pose2(
                x - reach * math.cos(heading + bearing), y - reach * math.sin(heading + bearing), float(heading)
            )
        else:
            pose = Pose2(
                float(rng.uniform(0, width)), float(rng.uniform(0, height)), float(rng.uniform(-math.pi, math.pi))
            )
        clear = all(math.hypot(pose.x - x, pose.y - y) > r + 0.15 for x, y, r, _ in ground.obstacles.tolist())
        if clear and -0.1 <= pose.x <= width + 0.1 and -0.1 <= pose.y <= height + 0.1:
            return pose
    return Pose2(width / 2, height / 2, 0.0)


def expose(
    field: Field, camera: CameraModel, pose: Pose2, pattern: NDArray[np.float32], rng: np.random.Generator
) -> Frame:
    """One frame from a pose, with the sensor's noise."""
    scene = field.plant.scene(pose.x, pose.y, pose.heading).reshape(camera.height, camera.width)
    noisy = scene + pattern + rng.standard_normal(scene.shape, dtype=np.float32) * NETD
    return Frame(np.clip(noisy * 100.0 + 0.5, 0, 65_535).astype(np.uint16), 0.0, 0)


def draw_pattern(camera: CameraModel, rng: np.random.Generator) -> NDArray[np.float32]:
    """Fixed pattern and vignetting (height, width) in kelvin, as one shutter calibration leaves them."""
    height, width = camera.height, camera.width
    v, u = np.mgrid[0:height, 0:width]
    corner = math.hypot(width, height) / 2
    radius = np.hypot(u - camera.cx, v - camera.cy) / corner
    pattern = rng.normal(0, PIXEL_PATTERN, (height, width)) - VIGNETTING * radius**2
    pattern += rng.normal(0, ROW_PATTERN, (height, 1)) + rng.normal(0, COLUMN_PATTERN, (1, width))
    return pattern.astype(np.float32)


def views(field: Field, camera: CameraModel, count: int, seed: int) -> Iterator[tuple[Pose2, Frame]]:
    """`count` frames of a field from random poses."""
    rng = np.random.default_rng([seed, 78])
    pattern = draw_pattern(camera, rng)
    for _ in range(count):
        pose = random_pose(field.ground, rng)
        yield pose, expose(field, camera, pose, pattern, rng)
