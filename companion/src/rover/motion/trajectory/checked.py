"""A path to segments that have been checked: what can't be shown to hold is driven more cautiously instead.

round the corners → segments → integrate what is sent → limits, path and swept footprint hold?
                                                        no: every corner is turned on the spot, and checked again
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike
from rover.errors import BadInput
from rover.motion.path.blend import BlendSettings, Stretch, blend_path
from rover.motion.path.clearance import ClearanceMap
from rover.motion.path.limits import DrivingLimits
from rover.motion.trajectory.extrema import Driven
from rover.motion.trajectory.plan import Trajectory, plan_segments

# Metres that the segments may be off the lines and curves that they were made from. The curves are driven exactly; this
# is what whole microseconds leave over a hundred corners, with room.
MAX_PATH_ERROR_M = 1e-4


@dataclass(frozen=True, eq=False)
class CheckedTrajectory:
    """Segments, what they were made from and what they do. `refused`: why no corner was rounded, or empty."""

    trajectory: Trajectory
    stretches: list[Stretch]
    driven: Driven
    refused: str = ""


def plan_checked(
    path: ArrayLike,
    limits: DrivingLimits,
    settings: BlendSettings | None = None,
    clearance: ClearanceMap | None = None,
    start_heading: float | None = None,
) -> CheckedTrajectory:
    """Segments along the polyline (N, 2) that keep the limits, the path and, with `clearance`, clear of everything.

    Raises BadInput when the path is no finite polyline or touches something itself. Where Ruckig knows no profile the
    segments end in a controlled stop, and the trajectory's `failure` says why.
    """
    settings = settings or BlendSettings()
    refused = ""
    for attempt in (settings, replace(settings, max_cut=0.0)):
        stretches = blend_path(path, limits, attempt, clearance)
        trajectory = plan_segments(stretches, limits, start_heading)
        driven = Driven(trajectory)
        wrong = _wrong(trajectory, stretches, driven, limits, clearance)
        if not wrong:
            return CheckedTrajectory(trajectory, stretches, driven, refused)
        refused = refused or wrong
    if clearance is not None and not driven.swept_clear(clearance):
        worst = driven.points[int(np.argmin(clearance.margin(driven.points)))]
        raise BadInput(f"the path touches what is not free near ({worst[0]:.2f}, {worst[1]:.2f}): plan it anew")
    raise BadInput(f"the path can't be driven within the limits: {wrong}")


def _wrong(
    trajectory: Trajectory,
    stretches: list[Stretch],
    driven: Driven,
    limits: DrivingLimits,
    clearance: ClearanceMap | None,
) -> str:
    broken = driven.extrema.broken(limits)
    if broken:
        return broken
    off = driven.off_pieces([piece for stretch in stretches for piece in stretch.pieces], trajectory.starts)
    if not off <= MAX_PATH_ERROR_M:
        return f"the segments leave the path by {off * 1e3:.2f} mm"
    if clearance is not None and not driven.swept_clear(clearance):
        return "the footprint touches what is not free"
    return ""
