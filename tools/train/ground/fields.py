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
from rover.vision.camera.model import CameraModel
from rover_hil.ground import Ground, Mine, build, daily_contrasts, lay_signature
from rover_hil.ground.field import lay_casing
from rover_hil.ground.signature import MINE_RADIUS_M, SURFACE_MINE_RADII_M
from rover_hil.ground.soils import soil_named
from rover_hil.ground.things import at_hour, lay_pebbles
from rover_hil.plant_config import build_plant
from rover_plant import Plant

# What the simulated sensor adds, standard deviations in kelvin, as the plant's camera does.
NETD = 0.05
ROW_PATTERN = 0.03
COLUMN_PATTERN = 0.04
PIXEL_PATTERN = 0.03
VIGNETTING = 0.4
# Depths of the mines that are laid beside those of the mission, metres: 0 stands on the ground. Deep mines are the
# hard ones: most of what is learned from lies deep.
DEPTHS = (0.0, 0.0, 0.0, 0.005, 0.01, 0.02, 0.03, 0.04, 0.05, 0.05, 0.06, 0.07)
# Share of the fields that are drawn by day, in the first soil of the list, and with many more pebbles.
BY_DAY, FIRST_SOIL, PEBBLY = 0.6, 0.4, 0.5
# Metres between the centres of mines, and from a buried mine to the edge of an obstacle.
BETWEEN_MINES, BESIDE_OBSTACLE = 0.65, 0.30
PLACING_TRIES = 60
DAY, ALL_DAY = (9.0, 16.5), (0.0, 24.0)
# Hours of the day from which nothing is learned: what is said of them is said of hours never seen.
HELD_OUT_HOURS = ((2.0, 3.0), (7.5, 8.5), (11.0, 12.0), (14.5, 15.5), (20.0, 21.0))


@dataclass(frozen=True, eq=False)
class Field:
    """One ground and the plant that renders it."""

    ground: Ground
    plant: Plant


def is_held_out(hour: float) -> bool:
    """True for hours of HELD_OUT_HOURS."""
    return any(begin <= hour < end for begin, end in HELD_OUT_HOURS)


def draw_hour(rng: np.random.Generator, held_out: bool) -> float:
    """An hour of the day, more often by day than at night, from among those held out or from among the others."""
    span = DAY if rng.random() < BY_DAY else ALL_DAY
    while True:
        hour = float(rng.uniform(*span))
        if is_held_out(hour) == held_out:
            return hour


def make_field(
    camera: CameraModel, soils: tuple[str, ...], seed: int, data: Path | None = None, held_out: bool = False
) -> Field | None:
    """A 3 x 4 m field drawn from the seed; None for a draw too full to place. `data`: real texture from there.

    held_out: at one of the hours that nothing is learned from.
    """
    rng = np.random.default_rng([seed, 77])
    base = config.load("demo")
    settings = replace(
        base.field,
        soil=soils[0] if rng.random() < FIRST_SOIL else str(rng.choice(soils)),
        rocks=int(rng.integers(2, 5)),
        grass=int(rng.integers(2, 4)),
        surface_mines=int(rng.integers(1, 3)),
        buried_mine_depths=(),
    )
    mission = replace(base, time_of_day_s=3600.0 * draw_hour(rng, held_out), field=settings)
    try:
        ground = build(mission, seed, data)
    except BadInput:
        return None
    if rng.random() < PEBBLY:
        now = at_hour(soil_named(settings.soil), mission.time_of_day_s / 3600.0)
        lay_pebbles(ground.temperature, ground.height, ground.grid, now, rng, per_square_metre=8.0)
    ground = _with_mines(ground, rng)
    return Field(ground, build_plant(mission, ground, camera, seed))


def _with_mines(ground: Ground, rng: np.random.Generator) -> Ground:
    """The same with as many more mines as fit: what is learned from needs no room to drive between them."""
    day = daily_contrasts(ground.soil, DEPTHS)
    width, length = ground.area
    mines = list(ground.mines)
    for _ in range(PLACING_TRIES):
        x, y = float(rng.uniform(0.0, width)), float(rng.uniform(0.0, length))
        near_mine = any(math.hypot(x - m.x, y - m.y) < BETWEEN_MINES for m in mines)
        if near_mine or any(math.hypot(x - a, y - b) < r + BESIDE_OBSTACLE for a, b, r, _ in ground.obstacles.tolist()):
            continue
        depth = float(rng.choice(DEPTHS))
        # Casings on the ground differ in size; buried ones are the reference disc.
        radius = float(rng.uniform(*SURFACE_MINE_RADII_M)) if depth == 0.0 else MINE_RADIUS_M
        profile = day.profile(depth, ground.hour, day.contrast.radius)
        lay_signature(ground.temperature, ground.grid, (x, y), day.contrast.radius * (radius / MINE_RADIUS_M), profile)
        if depth == 0.0:
            lay_casing(ground.height, ground.grid, (x, y, radius))
        peak = float(profile[np.argmax(np.abs(profile))])
        kind = "surface" if depth == 0.0 else "buried"
        mines.append(Mine(len(mines) + 1, x, y, radius, depth, kind, round(peak, 4)))
    return replace(ground, mines=tuple(mines))


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
    return np.asarray(pattern, np.float32)


def views(field: Field, camera: CameraModel, count: int, seed: int) -> Iterator[tuple[Pose2, Frame]]:
    """`count` frames of a field from random poses."""
    rng = np.random.default_rng([seed, 78])
    pattern = draw_pattern(camera, rng)
    for _ in range(count):
        pose = random_pose(field.ground, rng)
        yield pose, expose(field, camera, pose, pattern, rng)
