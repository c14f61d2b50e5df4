"""What one look at a simulated field shows: what every candidate lies on, and which mines are in view."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from rover.detection.classifier import CLASSES
from rover.detection.ground.candidates import EDGE
from rover.detection.ground.detect import CASING_MIDDLE
from rover.detection.ground.image import GroundImage
from rover.geometry import Pose2
from rover.vision.camera.model import CameraModel
from rover_hil.ground import Ground, Mine

FAR_AWAY = 9.0
# An obstacle's picture is its foot drawn out towards where this share of its height appears.
DRAWN_SHARE = 0.8
# A mine whose picture comes nearer than this, metres, to that of an obstacle's whole height may be hidden by it.
HIDDEN_WITHIN = 0.02


@dataclass(frozen=True, eq=False)
class Truth:
    """For each of N candidates: `mine`, the number of the nearest mine or -1; `to_mine`, metres from the middle of that
    mine's picture; `to_obstacle`, metres outside the nearest obstacle's picture, negative on it."""

    mine: NDArray[np.int64]
    to_mine: NDArray[np.float64]
    to_obstacle: NDArray[np.float64]


def truth_of(points: NDArray[np.float64], pose: Pose2, ground: Ground, camera: CameraModel) -> Truth:
    """What candidates at `points` (N, 2) of base_link lie on, seen from `pose`."""
    places = pose.transform(points)
    eye = pose.transform(np.array([[camera.x, camera.y]]))[0]
    mine, to_mine = np.full(len(places), -1), np.full(len(places), FAR_AWAY)
    for number, laid in enumerate(ground.mines):
        distance = np.hypot(*(places - appears_at(laid, eye, camera.z)).T)
        nearer = distance < to_mine
        mine[nearer], to_mine[nearer] = number, distance[nearer]
    to_obstacle = np.full(len(places), FAR_AWAY)
    for x, y, radius, height in ground.obstacles.tolist():
        outside = _to_picture(places, np.array([x, y]), eye, DRAWN_SHARE * height, camera.z) - radius
        to_obstacle = np.minimum(to_obstacle, outside)
    return Truth(mine, to_mine, to_obstacle)


def in_view(image: GroundImage, pose: Pose2, ground: Ground, camera: CameraModel) -> list[int]:
    """Numbers of the mines whose middle a candidate could lie on: in the picture, and behind no obstacle."""
    reach = round(EDGE / image.metres_per_pixel)
    whole = cv2.erode(np.pad(image.valid.astype(np.uint8), 1), np.ones((2 * reach + 1,) * 2, np.uint8), borderValue=0)
    eye = pose.transform(np.array([[camera.x, camera.y]]))[0]
    seen = []
    for number, laid in enumerate(ground.mines):
        place = appears_at(laid, eye, camera.z)[None]
        row, column = np.round(image.to_pixel(pose.inverse().transform(place))[0]).astype(int).tolist()
        if not (0 <= row < image.valid.shape[0] and 0 <= column < image.valid.shape[1] and whole[row + 1, column + 1]):
            continue
        if all(
            _to_picture(place, np.array([x, y]), eye, height, camera.z)[0] >= radius + laid.radius + HIDDEN_WITHIN
            for x, y, radius, height in ground.obstacles.tolist()
        ):
            seen.append(number)
    return seen


def appears_at(mine: Mine, eye: NDArray[np.float64], mast: float) -> NDArray[np.float64]:
    """Where on flat ground the middle of a mine appears; a casing that stands out is seen farther away."""
    centre = np.array([mine.x, mine.y])
    return drawn_out(centre, eye, CASING_MIDDLE, mast) if mine.kind == "surface" else centre


def drawn_out(xy: NDArray[np.float64], eye: NDArray[np.float64], height: float, mast: float) -> NDArray[np.float64]:
    """Where on flat ground a point `height` metres above `xy` appears to a camera `mast` metres up."""
    return eye + (xy - eye) * (mast / (mast - height))


def kind_of(mine: Mine) -> int:
    """The mine's class, as an index into CLASSES."""
    return CLASSES.index(mine.kind)


def _to_picture(
    points: NDArray[np.float64], foot: NDArray[np.float64], eye: NDArray[np.float64], height: float, mast: float
) -> NDArray[np.float64]:
    """Metres (N,) from points to the line from an upright thing's foot to where its top appears."""
    along = drawn_out(foot, eye, height, mast) - foot
    share = np.clip((points - foot) @ along / max(float(along @ along), 1e-12), 0.0, 1.0)
    away = points - foot - share[:, None] * along
    return np.asarray(np.hypot(away[:, 0], away[:, 1]))
