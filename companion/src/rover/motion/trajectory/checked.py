"""A path to segments that have been checked: what can't be shown to hold is driven more cautiously, only there.

lines, curves and bends ─▶ segments ─▶ integrate what is sent ─▶ limits hold? ─▶ path and footprint hold?
                               ▲                                    │ no            │ no: the rover turns on the
                               └── that piece is driven slower ◀────┘               │ spot at the corner there
     ▲──────────────────────────────────────────────────────────────────────────────┘
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from rover.errors import BadInput
from rover.motion.path.blend import Blend, blend_path
from rover.motion.path.clearance import ClearanceMap
from rover.motion.path.limits import DrivingLimits
from rover.motion.path.piece import Stretch
from rover.motion.path.rounding import BlendSettings
from rover.motion.trajectory.deviation import deviations
from rover.motion.trajectory.driven import Driven
from rover.motion.trajectory.plan import Trajectory, plan_segments

Array = NDArray[np.float64]

# Metres by which the driven path may be further off than the settings say: what rounding leaves.
MAX_PATH_ERROR_M = 1e-4
# So often corners are added at which the rover turns on the spot.
MAX_ATTEMPTS = 7


@dataclass(frozen=True, eq=False)
class CheckedTrajectory:
    """Segments, what they were made from and what they do. `deviation`: metres beside the path at most."""

    trajectory: Trajectory
    blend: Blend
    driven: Driven
    deviation: float

    @property
    def stretches(self) -> list[Stretch]:
        """What is driven without a stop."""
        return self.blend.stretches


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
    sharp: set[int] = set()
    for attempt in range(MAX_ATTEMPTS):
        if attempt == MAX_ATTEMPTS - 1:  # the polyline itself, turning on the spot at every corner
            settings = replace(settings, max_cut=0.0, widen=0.0)
        blend = blend_path(path, limits, settings, clearance, sharp)
        trajectory = plan_segments(blend.stretches, limits, start_heading)
        blend, driven = replace(blend, stretches=trajectory.stretches), Driven(trajectory)
        broken = driven.extrema.broken(limits)
        if broken and attempt < MAX_ATTEMPTS - 1:
            settings = replace(settings, max_cut=0.6 * settings.max_cut)
            continue
        if broken:
            raise BadInput(f"the path can't be driven within the limits: {broken}")
        beside = deviations(driven, blend, trajectory.starts)
        wrong = driven.points[:-1][beside > settings.max_cut + MAX_PATH_ERROR_M]
        if clearance is not None:
            wrong = np.concatenate([wrong, driven.touching(clearance)])
        if not len(wrong) or trajectory.failure:
            return CheckedTrajectory(trajectory, blend, driven, float(beside.max(initial=0.0)))
        sharp |= _corners_near(wrong, blend.points, sharp)
    x, y = wrong[0]
    if clearance is not None and len(driven.touching(clearance)):
        raise BadInput(f"the path touches what is not free near ({x:.2f}, {y:.2f}): plan it anew")
    raise BadInput(f"the path can't be followed closely enough near ({x:.2f}, {y:.2f})")


def _corners_near(places: Array, points: Array, known: set[int]) -> set[int]:
    """The corner of the polyline nearest to each of the first places, without those that are known already."""
    corners = np.array([number for number in range(1, len(points) - 1) if number not in known])
    if not len(corners):
        return set()
    found: set[int] = set()
    last: Array | None = None
    for place in places:
        # One corner for each place that is far enough from the last.
        if last is None or np.hypot(*(place - last)) > 0.1:
            found.add(int(corners[np.argmin(np.hypot(*(points[corners] - place).T))]))
            last = place
    return found
