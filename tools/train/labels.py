"""What a candidate really is, from the truth of a simulated field."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from rover.detection.detect import CASING_MIDDLE
from rover.geometry import Pose2
from rover.vision.camera import CameraModel
from rover_hil.ground import Ground

# Weaker mines than this, kelvin, cannot be told from soil by anybody: nothing is learned from them, but they are
# mines where the classifier is measured.
LEAST_CONTRAST = 0.25
# A candidate this near to a mine's picture is the mine; up to AMBIGUOUS it is neither. Metres.
NEAR = 0.05
AMBIGUOUS = 0.10
UNSURE = ""


def label(points: NDArray[np.float64], pose: Pose2, ground: Ground, camera: CameraModel, weakest: float) -> list[str]:
    """Class of every candidate, base_link (N, 2); UNSURE between two classes and at mines below `weakest` kelvin."""
    eye = pose.transform(np.array([[camera.x, camera.y]]))[0]
    labels = []
    for point in pose.transform(points):
        labels.append(_one(point, eye, ground, camera.z, weakest))
    return labels


def drawn_out(xy: NDArray[np.float64], eye: NDArray[np.float64], height: float, mast: float) -> NDArray[np.float64]:
    """Where on flat ground a point `height` metres above `xy` appears to a camera `mast` metres up."""
    return eye + (xy - eye) * (mast / (mast - height))


def _one(point: NDArray[np.float64], eye: NDArray[np.float64], ground: Ground, mast: float, weakest: float) -> str:
    for x, y, radius, height in ground.obstacles.tolist():
        foot = np.array([x, y])
        distance = _to_segment(point, foot, drawn_out(foot, eye, 0.8 * height, mast))
        if distance < radius + 0.01:
            return "obstacle"
        if distance < radius + 0.06:
            return UNSURE
    for mine in ground.mines:
        centre = np.array([mine.x, mine.y])
        if mine.kind == "surface":
            centre = drawn_out(centre, eye, CASING_MIDDLE, mast)
        distance = float(np.hypot(*(point - centre)))
        if distance < AMBIGUOUS:
            visible = abs(mine.contrast_k) >= weakest
            return mine.kind if distance < NEAR and visible else UNSURE
    return "background"


def _to_segment(point: NDArray[np.float64], a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    along = b - a
    share = float(np.clip((point - a) @ along / max(float(along @ along), 1e-12), 0.0, 1.0))
    return float(np.hypot(*(point - a - share * along)))
