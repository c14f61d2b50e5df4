"""What the follower of paths can be told: distances, times and limits of driving in closed loop."""

from __future__ import annotations

import math
from dataclasses import dataclass

from rover.vehicle import Limits

STEERING = Limits(0.5, 2.0, 8.0)


@dataclass(frozen=True)
class FollowerSettings:
    """Metres, seconds, radians."""

    horizon: float = 0.5  # motion is added when less than this is committed
    chunk: float = 0.2  # of driving, per call
    lookahead: float = 0.30  # where on the path the rover aims
    soft_corner: float = math.radians(8.0)  # driven through; sharper ones are turned on the spot
    arrival: float = 0.015  # nearer than this to a corner or the end counts as there
    heading_tolerance: float = math.radians(2.0)
    settle: float = 0.25  # after coming to rest, until the estimate is trusted
    turn_tries: int = 4
    max_off_path: float = 0.08  # beyond this the rover stops: the ground there was not part of the plan
    max_restarts: int = 5  # stops to aim anew on one stretch, before that too is given up
    min_speed: float = 0.05
    min_curve_speed: float = 0.08  # a corner that would be driven more slowly is turned on the spot
    steering: Limits = STEERING  # of heading while driving
    lateral: float = 0.2  # m/s², most that is planned on curves
    max_cut: float = 0.15  # metres between a corner and the curve that rounds it
    widen: float = 0.06  # metres that a corner may be moved outward by, to make room for its curve
    give: float = 0.045  # metres of margin that the map's margin holds besides; driving slows where there is less
    tracking: float = 0.0  # metres that the footprint grows by where a curve is checked against the map
