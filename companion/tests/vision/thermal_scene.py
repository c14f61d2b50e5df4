"""A driven thermal scene for the tests: textured plane, camera by inverse mapping, wheels that slip.

The plane carries random texture of several scales; the camera adds noise, and stripes on request. It shares only the
camera model with what is tested, so that an error in the estimators can't hide in it.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray
from rover.capture import Frame
from rover.geometry import Pose2
from rover.vehicle import STANDARD
from rover.vision.camera.model import CameraModel

STEP = 0.02
FRAME_STEPS = 6
RASTER = 0.005
ORIGIN = -2.0
SIDE = 8.0
START = Pose2(0.6, 0.6, 0.8)


def texture(rng: np.random.Generator, rms_kelvin: float = 0.3) -> NDArray[np.float32]:
    """Temperatures of the ground around 300 K, 5 mm a pixel: 2 to 40 cm scales of equal weight, given rms."""
    n = int(SIDE / RASTER)
    total = np.zeros((n, n), np.float32)
    for scale_m in (0.02, 0.05, 0.12, 0.4):
        coarse = rng.standard_normal((max(4, int(SIDE / scale_m)),) * 2).astype(np.float32)
        total += cv2.resize(coarse, (n, n), interpolation=cv2.INTER_CUBIC)
    kelvin: NDArray[np.float32] = 300.0 + (total - total.mean()) * np.float32(rms_kelvin / total.std())
    return kelvin


@dataclass
class ThermalScene:
    """Renders frames of `ground` (as from `texture`) as seen by `camera` from poses in the map."""

    camera: CameraModel
    ground: NDArray[np.float32]
    rng: np.random.Generator
    noise_kelvin: float = 0.05
    stripe_kelvin: float = 0.0
    _rays: NDArray[np.float64] = field(init=False)

    def __post_init__(self) -> None:
        w, h = self.camera.width, self.camera.height
        v, u = np.mgrid[0 : 2 * h, 0 : 2 * w]
        uv = np.column_stack((u.ravel(), v.ravel())) / 2.0 - 0.25
        self._rays = self.camera.pixel_to_ground(uv)
        self._stripes = self.stripe_kelvin * self.rng.standard_normal((1, w))

    def frame(self, pose: Pose2, time: float, sequence: int) -> Frame:
        """The frame exposed at `pose`: four samples a pixel, noise, kelvin × 100."""
        w, h = self.camera.width, self.camera.height
        at = ((pose.transform(self._rays) - ORIGIN) / RASTER - 0.5).astype(np.float32)
        fine = cv2.remap(
            self.ground,
            at[:, 0].reshape(2 * h, 2 * w),
            at[:, 1].reshape(2 * h, 2 * w),
            cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_REFLECT,
        )
        kelvin = cv2.resize(fine, (w, h), interpolation=cv2.INTER_AREA) + self._stripes
        kelvin = kelvin + self.noise_kelvin * self.rng.standard_normal(kelvin.shape)
        return Frame(np.round(kelvin * 100.0).astype(np.uint16), time, sequence)


@dataclass
class Drive:
    """Truth every 20 ms (poses), and what the wheels report for each step (metres, slipping and quantised)."""

    poses: list[Pose2]
    left: list[float]
    right: list[float]

    @property
    def distance(self) -> float:
        return sum(a.distance(b) for a, b in itertools.pairwise(self.poses))


def _profile(length: float, speed: float, acceleration: float) -> list[float]:
    """Positions along a trapezoid of speed, every STEP, ending exactly at `length`."""
    peak = min(speed, math.sqrt(length * acceleration))
    ramp = peak / acceleration
    total = length / peak + ramp
    out = []
    for k in range(1, math.ceil(total / STEP) + 1):
        t = min(k * STEP, total)
        if t < ramp:
            out.append(0.5 * acceleration * t * t)
        elif t < total - ramp:
            out.append(0.5 * peak * ramp + peak * (t - ramp))
        else:
            out.append(length - 0.5 * acceleration * (total - t) ** 2)
    return out


def drive(
    rng: np.random.Generator,
    distance: float,
    start: Pose2 = START,
    slip: float = 0.03,
    turn_speed: float = 1.1,
) -> Drive:
    """Random way points in a 3 × 4 m field, turning in place at each, until `distance` is driven.

    slip: bound of each wheel's constant scale error; a tenth of the travel wanders on top within a third of it.
    """
    poses = [start]
    travelled = 0.0
    while travelled < distance:
        here = poses[-1]
        target = (rng.uniform(0.4, 2.6), rng.uniform(0.4, 3.6))
        ahead = math.hypot(target[0] - here.x, target[1] - here.y)
        if ahead < 0.5:
            continue
        turn = Pose2(0, 0, math.atan2(target[1] - here.y, target[0] - here.x) - here.heading)
        angle = (turn.heading + math.pi) % (2 * math.pi) - math.pi
        for a in _profile(abs(angle), turn_speed, 3.0):
            poses.append(Pose2(here.x, here.y, here.heading + math.copysign(a, angle)))
        here = poses[-1]
        for s in _profile(ahead, 0.25, 0.5):
            poses.append(Pose2(here.x + s * math.cos(here.heading), here.y + s * math.sin(here.heading), here.heading))
        travelled += ahead
    return with_wheels(rng, poses, slip)


def with_wheels(rng: np.random.Generator, poses: list[Pose2], slip: float) -> Drive:
    """Wheel reports for true poses: constant and wandering scale errors, and whole encoder counts."""
    constant = rng.uniform(-slip, slip, 2)
    wander = np.zeros(2)
    exact = np.zeros(2)
    counted = np.zeros(2)
    left, right = [], []
    for a, b in itertools.pairwise(poses):
        step = b.relative_to(a)
        turn = step.heading
        true = np.array([step.x - turn * STANDARD.track_width / 2.0, step.x + turn * STANDARD.track_width / 2.0])
        # Ornstein-Uhlenbeck over distance: forgotten after about 0.5 m.
        share = np.minimum(1.0, np.abs(true) / 0.5)
        wander += -share * wander + np.sqrt(2.0 * share) * (slip / 3.0) * rng.standard_normal(2)
        exact += true * (1.0 + constant + wander)
        new = np.floor(exact / STANDARD.metres_per_count) * STANDARD.metres_per_count
        left.append(float(new[0] - counted[0]))
        right.append(float(new[1] - counted[1]))
        counted = new
    return Drive(poses, left, right)
