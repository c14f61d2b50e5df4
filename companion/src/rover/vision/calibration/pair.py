"""The thermal and the visible camera of one rover: their relative pose, and one's picture on the other's at the ground.

Both come from views of a board that the two cameras see at the same time.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.errors import BadInput
from rover.vision.calibration.fit import fit, rigid
from rover.vision.calibration.intrinsics import board_pose, project
from rover.vision.camera.model import CameraModel

Points = NDArray[np.float64]


@dataclass(frozen=True)
class Pair:
    """rotation (3, 3), translation (3,): from the first camera's optical frame to the second's, metres.

    covariance: (6, 6) of the rotation vector and the translation. rms: pixels, both pictures. view_rms: (V,).
    """

    rotation: Points
    translation: Points
    covariance: Points
    rms: float
    view_rms: Points


def pair_from_board(
    first: CameraModel, second: CameraModel, points: Points, views: Sequence[tuple[Points, Points]]
) -> Pair:
    """The pair's pose from views (first's, second's pixels (N, 2)) of one board `points` (N, 3).

    A board looks the same turned by half a turn: the order of the second's points that agrees is taken.
    Raises BadInput without a view.
    """
    if not views:
        raise BadInput("calibration: in no pair of pictures was the board found by both cameras")
    poses = np.stack([board_pose(first, points, mine) for mine, _ in views])
    observed = np.stack([np.stack((mine, _same_way(second, points, pose, other)))
                         for pose, (mine, other) in zip(poses, views, strict=True)])  # fmt: skip
    relative = [
        _relative(pose, board_pose(second, points, view[1])) for pose, view in zip(poses, observed, strict=True)
    ]
    start = np.median(np.stack(relative), axis=0)

    def residuals(shared: Points, moved: Points) -> Points:
        mine = rigid(moved, points)
        other = mine @ cv2.Rodrigues(shared[:3])[0].T + shared[3:]
        both = np.stack((project(first, mine), project(second, other)), axis=1)
        return (both - observed).reshape(len(observed), -1)

    found = fit(residuals, start, poses)
    rotation = np.asarray(cv2.Rodrigues(found.shared[:3])[0], np.float64)
    return Pair(rotation, found.shared[3:], found.covariance, found.rms, found.view_rms)


def ground_homography(first: CameraModel, second: CameraModel, pair: Pair) -> Points:
    """(3, 3): undistorted pixels of the first camera to those of the second, for points on the ground.

    The first camera must have a mount: the ground is its plane z = 0 of base_link.
    """
    up = first.base_from_camera.T @ np.array([0.0, 0.0, 1.0])  # the ground's normal in the optical frame
    plane = pair.rotation - np.outer(pair.translation, up) / first.z
    homography = second.matrix @ plane @ np.linalg.inv(first.matrix)
    normal: Points = homography / homography[2, 2]
    return normal


def _relative(first: Points, second: Points) -> Points:
    turn = cv2.Rodrigues(second[:3])[0] @ cv2.Rodrigues(first[:3])[0].T
    return np.concatenate((cv2.Rodrigues(turn)[0].ravel(), second[3:] - turn @ first[3:]))


def _same_way(second: CameraModel, points: Points, pose: Points, view: Points) -> Points:
    """The second camera's view in the order that needs the smaller turn between cameras: they look the same way."""
    turns = []
    for ordered in (view, view[::-1]):
        turns.append(float(np.linalg.norm(_relative(pose, board_pose(second, points, ordered))[:3])))
    return view if turns[0] <= turns[1] or turns[1] > math.pi / 2 else view[::-1]
