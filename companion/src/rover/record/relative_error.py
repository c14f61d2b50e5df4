"""How far the rover was from where it believed to be among the things around it; their place in map does not matter.

At a time t the nearest mapped zone or obstacle within a metre lies on ground that a keyframe of time k shows. The
rover's pose in that keyframe's frame is R = K⁻¹ P, with K and P the estimates as the map had them at t; the truth is
Rₜ = Kₜ⁻¹ Pₜ from the true poses at k and t. The error of a wheel w (base_link) is R w - Rₜ w. Both wheels and all times
count alike in the RMS. A time is inside its own 95 % bound when the error e of base_link has eᵀ C⁻¹ e below 5.991, the
95 % quantile of chi-square with two degrees of freedom, where C is the estimator's own covariance of R.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rover.errors import BadInput
from rover.geometry import Pose2, wrap_angle

BOUND_95 = 5.991


@dataclass(frozen=True, eq=False)
class RelativePose:
    """The rover at `time` in the frame of a keyframe of time `seen_at`; covariance (2, 2) of its position there."""

    time: float
    seen_at: float
    pose: Pose2
    covariance: NDArray[np.float64]


def relative_error(
    poses: Sequence[RelativePose], truth: NDArray[np.float64], wheel_offset: float
) -> tuple[float, float]:
    """RMS error of the wheels in metres, and the share of times inside their own 95 % bound.

    truth (N, 4): time, x, y, heading, times ascending; wheel_offset: of either wheel from base_link, metres. Poses of
    times that the truth does not cover are left out. Raises BadInput when none is left.
    """
    if not len(truth):
        raise BadInput("there is no truth")
    first, last = float(truth[0, 0]), float(truth[-1, 0])
    headings = np.unwrap(truth[:, 3])

    def real(time: float) -> Pose2:
        x, y, heading = (float(np.interp(time, truth[:, 0], row)) for row in (truth[:, 1], truth[:, 2], headings))
        return Pose2(x, y, wrap_angle(heading))

    wheels = np.array([[0.0, wheel_offset], [0.0, -wheel_offset]])
    squares, inside = [], []
    for one in poses:
        if not (first <= one.seen_at <= last and first <= one.time <= last):
            continue
        true = real(one.time).relative_to(real(one.seen_at))
        squares.append(float(np.square(one.pose.transform(wheels) - true.transform(wheels)).sum(axis=1).mean()))
        off = np.array([one.pose.x - true.x, one.pose.y - true.y])
        inside.append(float(off @ np.linalg.solve(one.covariance, off)) < BOUND_95)
    if not squares:
        raise BadInput("no pose among things of known time")
    return math.sqrt(float(np.mean(squares))), float(np.mean(inside))
