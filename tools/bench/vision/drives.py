"""Drives over simulated fields: how far off is the pose, does the covariance say so, is the rover found again?

The plant's renderer draws the frames: the demo's field with its heat model, obstacles that stand above the ground,
sensor noise, fixed pattern and vignetting. Frames come every 0.12 s and arrive 60 ms late.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from rover.capture.frame import Frame
from rover.errors import BadInput
from rover.geometry import Pose2, wrap_angle
from rover.mission import config
from rover.vision.camera.model import CameraModel
from rover.vision.localization.localizer import Localizer
from rover.vision.localization.settings import LocalizerSettings
from rover_hil.ground import build
from rover_hil.plant_config import build_plant

from tools.bench.vision.way import STEP_M, Drive, along, circuit, free_place, reported, wander
from tools.train.ground.fields import Field, draw_pattern, expose

FRAME_STEPS, LATENCY_STEPS = 6, 3
START_SIGMA = (0.005, 0.005, 0.005)


@dataclass
class Track:
    """errors (N, 3): x, y (m), heading (rad), one a frame. nees (N,). refused: frames. lost (N,): it said so."""

    errors: list[NDArray[np.float64]] = field(default_factory=list)
    nees: list[float] = field(default_factory=list)
    refused: int = 0
    lost: list[bool] = field(default_factory=list)

    def rms_m(self, first: int = 0, last: int | None = None) -> float:
        """Root mean square distance from the truth."""
        some = np.array(self.errors[first:last])
        return float(np.sqrt(np.mean(np.sum(some[:, :2] ** 2, axis=1))))

    def heading_deg(self) -> float:
        """Root mean square error of the heading."""
        return math.degrees(float(np.sqrt(np.mean(np.array(self.errors)[:, 2] ** 2))))

    def heading_deg_placed(self) -> float:
        """The same without the moments at which it said that it was lost."""
        placed = np.array(self.errors)[~np.array(self.lost)]
        return math.degrees(float(np.sqrt(np.mean(placed[:, 2] ** 2))))

    def add(self, estimate: Pose2, covariance: NDArray[np.float64] | None, truth: Pose2, lost: bool = False) -> None:
        """One estimate beside the truth."""
        self.lost.append(lost)
        turn = wrap_angle(estimate.heading - truth.heading)
        error = np.array([estimate.x - truth.x, estimate.y - truth.y, turn])
        self.errors.append(error)
        if covariance is not None:
            self.nees.append(float(error @ np.linalg.solve(covariance, error)))


@dataclass
class Scene:
    """A field as its camera shows it."""

    field: Field
    camera: CameraModel
    pattern: NDArray[np.float32]
    rng: np.random.Generator

    def frame(self, pose: Pose2, step: int) -> Frame:
        """The frame exposed at `step`."""
        shown = expose(self.field, self.camera, pose, self.pattern, self.rng)
        return Frame(shown.counts, step * STEP_M, step // FRAME_STEPS)


def scene(camera: CameraModel, seed: int) -> Scene | None:
    """The demo's field of that seed; None where it is too full to lay."""
    mission = config.load("demo")
    rng = np.random.default_rng([seed, 51])
    try:
        ground = build(mission, seed)
    except BadInput:
        return None
    return Scene(Field(ground, build_plant(mission, ground, camera, seed)), camera, draw_pattern(camera, rng), rng)


def scenes(camera: CameraModel, count: int, first: int) -> Iterator[tuple[int, Scene]]:
    """`count` fields from seed `first` on."""
    found = ((seed, scene(camera, seed)) for seed in itertools.count(first))
    laid = ((seed, made) for seed, made in found if made is not None)
    return itertools.islice(laid, count)


def random_drive(at: Scene, slip: float, length: float) -> Drive:
    """A random way of `length` metres through the field."""
    ground = at.field.ground
    x, y = free_place(ground, at.rng)
    start = Pose2(x, y, float(at.rng.uniform(-math.pi, math.pi)))
    return reported(along(start, wander(ground, (x, y), length, at.rng)), slip, at.rng)


def loops(at: Scene, slip: float, count: int) -> tuple[Drive, int]:
    """The same closed way `count` times, and the number of steps of one."""
    places = circuit(at.field.ground, at.rng)
    start = Pose2(*places[0], math.atan2(places[1][1] - places[0][1], places[1][0] - places[0][0]))
    once = along(start, [*places[1:], places[0]])
    poses = along(start, [*places[1:], places[0]] * count)
    return reported(poses, slip, at.rng), len(once)


@dataclass
class Run:
    """fused, frames, wheels: the three estimates over one drive; the localizer at its end."""

    localizer: Localizer
    fused: Track = field(default_factory=Track)
    frames: Track = field(default_factory=Track)
    wheels: Track = field(default_factory=Track)


def follow(at: Scene, drive: Drive, settings: LocalizerSettings | None = None, frames_alone: bool = True) -> Run:
    """Wheels and frames as they come; the start is known to START_SIGMA and is off by as much."""
    settings = settings or LocalizerSettings()
    start = drive.poses[0]
    dx, dy, turn = (at.rng.standard_normal(3) * START_SIGMA).tolist()
    told = Pose2(start.x + dx, start.y + dy, start.heading + turn)
    run = Run(Localizer(at.camera, told, START_SIGMA, settings))
    alone = Localizer(at.camera, told, START_SIGMA, replace(settings, motion="frames"))
    late: list[tuple[int, Frame]] = []
    for step in range(1, len(drive.poses)):
        run.localizer.predict(step * STEP_M, drive.left[step - 1], drive.right[step - 1])
        truth = drive.poses[step]
        if step % FRAME_STEPS == 0:
            late.append((step, at.frame(truth, step)))
        if late and late[0][0] + LATENCY_STEPS <= step:
            taken, frame = late.pop(0)
            run.fused.refused += not run.localizer.observe(frame).accepted
            run.fused.add(run.localizer.pose, run.localizer.covariance, truth, run.localizer.lost)
            run.wheels.add(run.localizer.odometry_only, None, truth)
            if frames_alone:
                run.frames.refused += not alone.observe(frame).accepted
                run.frames.add(alone.pose, alone.covariance, drive.poses[taken], alone.lost)
    return run
