"""The localizer's answer to one frame."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Fix:
    """What became of one frame. Pose in map (metres, radians) as the frame alone says; reason: why it was refused.

    offset: how far the camera is found to show the ground off where it is, metres, with the larger 1σ of that.
    """

    time: float
    accepted: bool
    reason: str = ""
    keypoints: int = 0
    matches: int = 0
    inliers: int = 0
    residual_px: float = 0.0
    x: float = math.nan
    y: float = math.nan
    heading: float = math.nan
    keyframe: bool = False
    offset: float = 0.0
    offset_sigma: float = 0.0
