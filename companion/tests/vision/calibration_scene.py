"""Pictures of boards and boxes by tracing every ray: the truth that a calibration has to find again.

Shares only the camera model with what is tested. Four by four rays a pixel, then blur and noise as of a thermal camera.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray
from rover.vision.calibration.board import Board
from rover.vision.camera.model import CameraModel

RAYS = 4
# Board coordinates in metres to 0 (background), or up to 1.
Pattern = Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.float64]]


def checkerboard(board: Board) -> Pattern:
    """Squares around the inner corners, a rim of one square about them."""

    def paint(x, y):
        i, j = np.floor(x / board.square) + 1, np.floor(y / board.square) + 1
        inside = (i >= 0) & (i <= board.columns) & (j >= 0) & (j <= board.rows)
        return np.where(inside & ((i + j) % 2 == 0), 1.0, 0.0)

    return paint


def circle_grid(board: Board, radius_share: float = 0.3) -> Pattern:
    def paint(x, y):
        i = np.clip(np.round(x / board.square), 0, board.columns - 1)
        j = np.clip(np.round(y / board.square), 0, board.rows - 1)
        return np.where(np.hypot(x - i * board.square, y - j * board.square) < radius_share * board.square, 1.0, 0.0)

    return paint


def staggered_grid(board: Board, radius_share: float = 0.5) -> Pattern:
    """Circles at the board's own points; the radius is a share of the distance between rows."""
    centres = board.points[:, :2]

    def paint(x, y):
        value = np.zeros(np.shape(x))
        for at_x, at_y in centres:
            value[np.hypot(x - at_x, y - at_y) < radius_share * board.square] = 1.0
        return value

    return paint


def box(width: float, height: float) -> Pattern:
    return lambda x, y: np.where((x >= 0) & (x <= width) & (y >= 0) & (y <= height), 1.0, 0.0)


def pose(middle: tuple[float, float], distance: float, roll: float, tilt_x: float, tilt_y: float, aim=(0.0, 0.0)):
    """R (3, 3), t (3,): the board's `middle` at `distance` ahead, moved aside by `aim` (share of the distance)."""
    rx, ry, rz = (
        cv2.Rodrigues(np.array(axis, dtype=np.float64))[0] for axis in ((tilt_x, 0, 0), (0, tilt_y, 0), (0, 0, roll))
    )
    rotation = rx @ ry @ rz
    target = distance * np.array([aim[0], aim[1], 1.0])
    return rotation, target - rotation @ np.array([*middle, 0.0])


@cache
def rays_of(camera: CameraModel) -> NDArray[np.float64]:
    """Directions (N, 3) of all rays of a picture, row by row."""
    v, u = np.mgrid[0 : RAYS * camera.height, 0 : RAYS * camera.width]
    uv = (np.column_stack((u.ravel(), v.ravel())) + 0.5) / RAYS - 0.5
    return np.column_stack((camera.pixel_to_normalized(uv), np.ones(len(uv))))


def render(
    camera: CameraModel,
    pattern: Pattern,
    where: tuple[NDArray[np.float64], NDArray[np.float64]],
    rng: np.random.Generator,
    hot: bool = True,
    blur_px: float = 0.8,
    noise: float = 0.02,
    bits: int = 16,
) -> NDArray[np.uint8 | np.uint16]:
    """A picture (H, W): contrast of 1 is 8 K in kelvin × 100 (16 bits) or 160 grey levels (8 bits)."""
    w, h = camera.width, camera.height
    rays = rays_of(camera)
    rotation, translation = where
    normal = rotation[:, 2]
    reach = (normal @ translation) / (rays @ normal)
    on_board = (rays * reach[:, None] - translation) @ rotation
    value = np.where(reach > 0, pattern(on_board[:, 0], on_board[:, 1]), 0.0).reshape(RAYS * h, RAYS * w)
    picture = cv2.GaussianBlur(cv2.resize(value, (w, h), interpolation=cv2.INTER_AREA), (0, 0), blur_px)
    picture = (picture if hot else 1.0 - picture) + noise * rng.standard_normal((h, w))
    if bits == 16:
        return np.clip(29500 + 800 * picture, 0, 65535).astype(np.uint16)
    return np.clip(40 + 160 * picture, 0, 255).astype(np.uint8)


def tilted_poses(board: Board, camera: CameraModel, count: int, rng: np.random.Generator, fill: float = 0.62):
    """Poses as a person takes them: the board fills most of the picture, tilted to each side, off the middle."""
    middle = ((board.columns - 1) / 2 * board.square, (board.rows - 1) / 2 * board.square)
    distance = camera.fx * (board.columns + 1) * board.square / (fill * camera.width)
    poses = []
    for number in range(count):
        around = 2 * math.pi * number / count
        tilt = math.radians(rng.uniform(18, 38))
        aim = 0.16 * np.array([math.cos(2.4 * number), math.sin(2.4 * number) * 0.75]) * camera.width / camera.fx
        poses.append(
            pose(
                middle,
                distance * rng.uniform(1.0, 1.35),
                rng.uniform(-0.2, 0.2),
                tilt * math.cos(around),
                tilt * math.sin(around),
                tuple(aim),
            )
        )
    return poses
