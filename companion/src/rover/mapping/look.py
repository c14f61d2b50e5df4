"""What one frame shows of the ground, point by point: plain ground, something that stands there, and how warm it is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.capture.frame import Frame
from rover.geometry import Pose2
from rover.mapping.camera_view import CameraView, holds
from rover.mapping.rectangle import Rectangle
from rover.mapping.shadow import obstacle_cover
from rover.mapping.spot import ClassifiedSpot
from rover.mapping.thermal_anomaly import anomalies


@dataclass(frozen=True, eq=False)
class Look:
    """Points (N,) of a frame by their cells, several to a cell. shown: plain ground; solid: an obstacle; kelvin."""

    rows: NDArray[np.intp]
    columns: NDArray[np.intp]
    shown: NDArray[np.bool_]
    solid: NDArray[np.bool_]
    kelvin: NDArray[np.float32]


def look_at(
    frame: Frame,
    view: CameraView,
    pose: Pose2,
    resolution: float,
    limits: Rectangle,
    detections: Sequence[ClassifiedSpot],
) -> Look | None:
    """What a frame from `pose` shows within `limits`; None when it shows nothing there."""
    columns, rows = np.floor(pose.transform(view.points.astype(np.float64)) / resolution).astype(np.intp).T
    inside = (rows >= limits.top) & (columns >= limits.left) & (rows < limits.bottom) & (columns < limits.right)
    inside &= holds(frame, view.maps)
    if not inside.any():
        return None
    # The stub does not know that a map of two channels needs no second map.
    taken = cv2.remap(frame.kelvin(), view.maps, None, cv2.INTER_LINEAR)  # type: ignore[call-overload]
    kelvin: NDArray[np.float32] = taken[:, 0]
    cover = obstacle_cover(view, detections)
    strong, weak = anomalies(kelvin)
    solid = (cover.obstacle & (weak | cover.core)) | (strong & ~cover.explained & ~cover.hidden)
    shown = ~cover.hidden & ~cover.obstacle & ~solid
    return Look(rows[inside], columns[inside], shown[inside], solid[inside], kelvin[inside])
