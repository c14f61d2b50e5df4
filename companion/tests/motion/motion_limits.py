"""The check that motion keeps the vehicle's limits, shared by the tests of profiles and of the follower."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from rover.motion import Segment, State
from rover.motion.segment import advance, after
from rover.vehicle import Limits, Vehicle

TRAVEL, HEADING = Vehicle().travel, Vehicle().heading


def assert_within_limits(
    segments: Iterable[Segment], state: State, travel: Limits = TRAVEL, heading: Limits = HEADING
) -> None:
    """Speed, acceleration and jerk of both axes, 40 times per segment; the tolerance is quantisation's."""
    for segment in segments:
        assert abs(segment.jerk_travel) <= travel.jerk * 1.001e6
        assert abs(segment.jerk_heading) <= heading.jerk * 1.001e6
        for t in np.linspace(0.0, segment.duration_us * 1e-6, 40):
            at = advance(state, segment.jerk_travel * 1e-6, segment.jerk_heading * 1e-6, float(t))
            assert abs(at.speed) <= travel.speed + 1e-4
            assert abs(at.acceleration) <= travel.acceleration + 1e-4
            assert abs(at.turn_rate) <= heading.speed + 1e-4
            assert abs(at.turn_acceleration) <= heading.acceleration + 1e-4
        state = after(state, segment)
