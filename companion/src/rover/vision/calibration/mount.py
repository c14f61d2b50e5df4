"""Where the camera sits on the rover, from points on the ground that were measured in base_link (eq. 11).

PnP on the ground plane gives the start, an adjustment of position and rotation the rest, with its covariance.
"""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.errors import BadInput
from rover.plain_file import plain_file
from rover.vision.calibration.fit import fit
from rover.vision.camera.model import OPTICAL_IN_LEVEL, CameraModel

Points = NDArray[np.float64]

MIN_POINTS = 4
# The points' smaller extent as a share of the larger one: below it they lie on a line.
MIN_SPREAD = 0.05

# Largest standard deviation of the position, as a share of the height, with which a mount is given out.
MAX_POSITION_SIGMA = 0.2

MOUNT = ("x", "y", "z", "roll", "pitch", "yaw")


@dataclass(frozen=True)
class Mounted:
    """camera: with its mount. covariance: (6, 6) of x, y, z, roll, pitch, yaw. rms, errors: pixels, all and each."""

    camera: CameraModel
    covariance: Points
    rms: float
    errors: Points


def read_points(file: Path, columns: tuple[str, ...]) -> Points:
    """A CSV file with a header that names at least `columns`, (N, len(columns)). Raises BadInput naming the line."""
    try:
        rows = list(csv.DictReader(plain_file(file).read_text(encoding="utf-8").splitlines()))
    except (OSError, UnicodeDecodeError) as error:
        raise BadInput(f"{file}: cannot be read as a table of points ({error})") from error
    values = []
    for number, row in enumerate(rows, start=2):
        try:
            values.append([float(row[column]) for column in columns])
        except (KeyError, TypeError, ValueError) as error:
            wanted = ", ".join(columns)
            raise BadInput(f"{file}, line {number}: numbers in columns {wanted} are expected") from error
    points = np.array(values).reshape(-1, len(columns))
    if not np.isfinite(points).all():
        raise BadInput(f"{file}: a value is not finite")
    return points


def mount_from_ground(camera: CameraModel, pixels: Points, ground: Points) -> Mounted:
    """The mount from pixels (N, 2) and where they lie on the ground in base_link (N, 2), metres.

    Raises BadInput for too few points, points on a line, or points that do not determine the mount.
    """
    if len(pixels) < MIN_POINTS:
        raise BadInput(f"ground points: {len(pixels)} are given, at least {MIN_POINTS} are needed, better 8 or more")
    extent = np.linalg.svd(ground - ground.mean(axis=0), compute_uv=False)
    if extent[1] < MIN_SPREAD * extent[0]:
        raise BadInput("ground points: they lie on one line; spread them over the ground that the camera sees")
    start = _start(camera, pixels, ground)

    def placed(shared: Points) -> CameraModel:
        turned = cv2.Rodrigues(shared[3:])[0] @ start.base_from_camera
        return replace(start, **dict(zip(MOUNT, (*(start.position + shared[:3]), *angles_of(turned)), strict=True)))

    def residuals(shared: Points, _: Points) -> Points:
        return np.nan_to_num(placed(shared).ground_to_pixel(ground) - pixels, nan=1e4).reshape(1, -1)

    found = fit(residuals, np.zeros(6), np.zeros((1, 0)))
    result = placed(found.shared)
    errors = np.linalg.norm(found.residuals.reshape(-1, 2), axis=1)
    turn = np.column_stack([_angle_change(result, axis) for axis in range(3)])
    to_mount = np.block([[np.eye(3), np.zeros((3, 3))], [np.zeros((3, 3)), turn]])
    covariance = to_mount @ found.covariance @ to_mount.T
    if result.z <= 0.0 or math.sqrt(covariance[:3, :3].trace()) > MAX_POSITION_SIGMA * result.z:
        raise BadInput(
            f"ground points: they do not determine the mount (errors of {found.rms:.1f} px RMS): "
            "check that each pixel belongs to its point, and spread the points"
        )
    return Mounted(result, covariance, found.rms, errors)


def angles_of(base_from_camera: Points) -> tuple[float, float, float]:
    """Roll, pitch, yaw of a mount from its rotation (3, 3); straight down, yaw alone turns the picture."""
    turn = base_from_camera @ OPTICAL_IN_LEVEL.T
    pitch = math.asin(min(1.0, max(-1.0, -turn[2, 0])))
    if abs(turn[2, 0]) > 1.0 - 1e-12:
        return 0.0, pitch, math.atan2(-turn[0, 1], turn[1, 1])
    return math.atan2(turn[2, 1], turn[2, 2]), pitch, math.atan2(turn[1, 0], turn[0, 0])


def _start(camera: CameraModel, pixels: Points, ground: Points) -> CameraModel:
    points = np.column_stack((ground, np.zeros(len(ground))))
    good, rotations, translations, errors = cv2.solvePnPGeneric(
        points, camera.pixel_to_normalized(pixels), np.eye(3), None, flags=cv2.SOLVEPNP_IPPE
    )
    if not good:
        raise BadInput("ground points: no camera can see them so")
    best = None
    for rotation, translation, error in zip(rotations, translations, np.asarray(errors).ravel(), strict=True):
        base_from_camera = cv2.Rodrigues(rotation)[0].T
        position = -base_from_camera @ translation.ravel()
        if position[2] > 0 and (best is None or error < best[0]):
            best = float(error), position, base_from_camera
    if best is None:
        raise BadInput("ground points: they would be seen from below the ground: is x forward and y left?")
    return replace(camera, **dict(zip(MOUNT, (*best[1].tolist(), *angles_of(best[2])), strict=True)))


def _angle_change(camera: CameraModel, axis: int) -> Points:
    """How roll, pitch and yaw change with a small turn about an axis of base_link, (3,)."""
    step = 1e-6
    turns = []
    for sign in (1.0, -1.0):
        vector = np.zeros(3)
        vector[axis] = sign * step
        turns.append(np.array(angles_of(cv2.Rodrigues(vector)[0] @ camera.base_from_camera)))
    change = turns[0] - turns[1]
    wrapped: Points = (change + math.pi) % (2.0 * math.pi) / (2.0 * step) - math.pi / (2.0 * step)
    return wrapped
