"""A box of known size as the only target: its four corners give the focal length, and nothing finer.

One view of a rectangle holds two constraints on the camera. With the centre in the middle and no distortion they give
the focal lengths; a board gives everything. This is the paper's target (section 4.2: 33.5 cm × 22.5 cm).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.errors import BadInput
from rover.vision.calibration.board import stretched
from rover.vision.calibration.intrinsics import MAX_FOCAL_SIGMA, Calibration, Freedom, board_pose, calibrated
from rover.vision.camera.model import CameraModel

Points = NDArray[np.float64]

# Area of the box as a share of the picture's.
MIN_SHARE, MAX_SHARE = 0.02, 0.9

# In widths of the picture.
START_FOCALS = (0.8, 1.2, 1.8, 2.8)

# Share of a side next to a corner that its line does not use: there blur rounds it.
EDGE_MARGIN = 0.15


def box_points(width: float, height: float) -> Points:
    """The corners (4, 3) of a box's face in metres, going around."""
    return np.array([[0.0, 0.0, 0.0], [width, 0.0, 0.0], [width, height, 0.0], [0.0, height, 0.0]])


def find_box(picture: NDArray[Any]) -> Points | None:
    """Corners (4, 2), clockwise as seen, of the hot or cold quadrilateral in a picture (H, W); None without one."""
    grey = cv2.GaussianBlur(stretched(picture), (0, 0), 1.0)
    level, _ = cv2.threshold(grey, 0, 255, cv2.THRESH_BINARY + cv2.THRESH_OTSU)
    best: tuple[float, Points] | None = None
    for polarity, limit in ((grey, level), (cv2.bitwise_not(grey), 255.0 - level)):
        mask = (polarity > limit).astype(np.uint8)
        outlines, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
        for outline in outlines:
            share = cv2.contourArea(outline) / mask.size
            rough = cv2.approxPolyDP(outline, 0.03 * cv2.arcLength(outline, True), True).reshape(-1, 2)
            inside = outline.min() > 0 and (outline.reshape(-1, 2).max(axis=0) < np.array(mask.shape[::-1]) - 1).all()
            if len(rough) == 4 and inside and MIN_SHARE < share < MAX_SHARE and (not best or share > best[0]):
                best = share, _sharpened(np.asarray(polarity, np.uint8), rough.astype(np.float64), float(limit))
    if best is None:
        return None
    corners = best[1]
    return corners if cv2.contourArea(corners.astype(np.float32), True) > 0 else corners[::-1].copy()


def calibrate_box(
    width: float, height: float, views: Sequence[Points], size: tuple[int, int], name: str = "camera"
) -> Calibration:
    """Focal length, square pixels, centre in the middle. Raises BadInput when the views do not determine it."""
    if not views:
        raise BadInput("calibration: the box was found in none of the pictures")
    points = box_points(width, height)
    best: Calibration | None = None
    for share in START_FOCALS:
        start = CameraModel(name, *size, share * size[0], share * size[0], (size[0] - 1) / 2.0, (size[1] - 1) / 2.0)
        # Which side is the long one is not seen: take what fits.
        ordered = np.stack([min((np.roll(v, -k, axis=0) for k in (0, 1)), key=lambda o: _misfit(start, points, o))
                            for v in views])  # fmt: skip
        found = calibrated(points, ordered, start, Freedom(distortion=0, square=True, centre=False))
        if best is None or found.rms < best.rms:
            best = found
    assert best is not None
    looseness = best.sigmas["f"] / best.camera.fx
    if not (0.2 * size[0] < best.camera.fx < 50 * size[0] and looseness < 5.0 * MAX_FOCAL_SIGMA):
        raise BadInput(
            "calibration: the box does not determine the focal length: it is seen from the front; turn it by 30° to 50°"
        )
    return best


def _misfit(camera: CameraModel, points: Points, view: Points) -> float:
    pose = board_pose(camera, points, view)
    moved = points @ cv2.Rodrigues(pose[:3])[0].T + pose[3:]
    return float(np.linalg.norm(camera.normalized_to_pixel(moved[:, :2] / moved[:, 2:]) - view))


def _sharpened(grey: NDArray[np.uint8], rough: Points, level: float) -> Points:
    """Corners as crossings of lines through where each side's profile crosses the level."""
    lines = []
    for start, end in zip(rough, np.roll(rough, -1, axis=0), strict=True):
        along = end - start
        length = float(np.linalg.norm(along))
        normal = np.array([-along[1], along[0]]) / length
        share = np.linspace(EDGE_MARGIN, 1.0 - EDGE_MARGIN, max(8, int(2 * length)))
        offsets = np.arange(-4.0, 4.01, 0.25)
        at = (start + share[:, None] * along)[:, None, :] + offsets[None, :, None] * normal
        profile = cv2.remap(grey.astype(np.float32), at[..., 0].astype(np.float32), at[..., 1].astype(np.float32),
                            cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)  # fmt: skip
        above = profile > level
        steps = above[:, 1:] != above[:, :-1]
        known = steps.any(axis=1)
        middle = len(offsets) // 2
        nearest = np.where(steps, np.abs(np.arange(steps.shape[1]) - middle), 10**6).argmin(axis=1)
        rows = np.arange(len(share))
        low, high = profile[rows, nearest], profile[rows, nearest + 1]
        cross = offsets[nearest] + 0.25 * (level - low) / np.where(high == low, 1.0, high - low)
        points = (start + share[:, None] * along + cross[:, None] * normal)[known].astype(np.float32)
        if len(points) < 4:
            return rough
        vx, vy, x, y = cv2.fitLine(points, cv2.DIST_HUBER, 0, 0.01, 0.01).ravel()
        lines.append(np.cross([x, y, 1.0], [x + vx, y + vy, 1.0]))
    corners = [np.cross(lines[index - 1], lines[index]) for index in range(4)]
    return np.array([corner[:2] / corner[2] for corner in corners])
