"""A camera's metric way over flat ground from its frames alone: its mount gives the scale.

The localizer works as on the rover, without wheels. The map's origin is base_link (the ground below the camera's mount
point) at the first frame that is tracked, x ahead.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from rover.capture.frame import Frame
from rover.errors import BadInput
from rover.geometry import Pose2
from rover.vision.camera.model import CameraModel
from rover.vision.camera.pose import CameraPose
from rover.vision.localization.keyframe_map import KeyframeMap
from rover.vision.localization.localizer import Localizer
from rover.vision.localization.motion_model import FreeMotionNoise
from rover.vision.localization.settings import LocalizerSettings

# The first frame defines the map.
START_SIGMA = (1e-4, 1e-4, 1e-4)

# Who carries the camera is not known: it may start, stop and turn faster than the rover.
UNKNOWN_CARRIER = FreeMotionNoise(speed=0.5, turn=2.0, acceleration=1.5, turn_acceleration=6.0, sideways=0.05)


def camera_in_map(base: Pose2, camera: CameraModel) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Position (3,) and rotation (3, 3) of camera_optical in map while base_link is at `base`."""
    c, s = math.cos(base.heading), math.sin(base.heading)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return turn @ camera.position + (base.x, base.y, 0.0), turn @ camera.base_from_camera


def track_over_ground(
    frames: Sequence[Frame],
    camera: CameraModel,
    advance: Callable[[int, int], None] = lambda done, total: None,
    known: KeyframeMap | None = None,
) -> list[CameraPose]:
    """Poses in map, metres, of the frames that could be placed; advance: told how many of how many are done.

    known: keyframes of a run; poses are then in that run's map, from the frame on whose ground is recognised.

    Raises BadInput for a camera whose mount shows it no ground.
    """
    if not np.isfinite(camera.ground_lookup).any():
        raise BadInput(f"camera {camera.name}: no pixel shows the ground; mount.pitch_deg is positive downwards")
    settings = replace(LocalizerSettings(), motion="frames", free_noise=UNKNOWN_CARRIER)
    localizer = Localizer(camera, Pose2(0.0, 0.0, 0.0), START_SIGMA, settings, known=known)
    poses = []
    for number, frame in enumerate(frames):
        if localizer.observe(frame).accepted:
            poses.append(CameraPose(number, *camera_in_map(localizer.pose, camera)))
        advance(number + 1, len(frames))
    return poses
