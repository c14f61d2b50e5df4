"""What segments that are about to be sent ask of both axes: the last look before they cannot be taken back.

The same limits as `rover.motion.trajectory.checked` holds whole trajectories to; a mission sends half a second at a
time, steered, so nothing but the segments themselves says what they do.
"""

from __future__ import annotations

from collections.abc import Sequence

from rover.motion.path.limits import DrivingLimits
from rover.motion.segment import Segment, State, advance, after
from rover.motion.trajectory.extrema import Extrema

# Share by which whole microseconds and quantised jerks may exceed a limit.
ROUNDING = 2e-3
# Times within a segment at which the lateral acceleration is looked at.
LATERAL_STEPS = 8


def broken(state: State, segments: Sequence[Segment], limits: DrivingLimits) -> str:
    """Which limit segments that follow on `state` exceed, in words; empty when none is."""
    most = Extrema(*(0.0,) * 7)
    for segment in segments:
        state = state.rested() if segment.begin else state
        most = _larger(most, _extrema(state, segment))
        state = after(state, segment)
    share = 1.0 / (1.0 + ROUNDING)
    scaled = Extrema(*(share * value for value in vars(most).values()))
    return scaled.broken(limits)


def _extrema(state: State, segment: Segment) -> Extrema:
    """Of one segment: speeds are quadratic in time, so largest at an end or where the acceleration is zero."""
    duration = segment.duration_us * 1e-6
    travel, heading = segment.jerk_travel * 1e-6, segment.jerk_heading * 1e-6
    times = {0.0, duration}
    for acceleration, jerk in ((state.acceleration, travel), (state.turn_acceleration, heading)):
        if jerk and 0.0 < -acceleration / jerk < duration:
            times.add(-acceleration / jerk)
    # Speed times turn rate has its peak somewhere between: a fine row of times is near enough.
    times |= {duration * share / LATERAL_STEPS for share in range(1, LATERAL_STEPS)}
    states = [advance(state, travel, heading, time) for time in sorted(times)]
    return Extrema(
        max(abs(at.speed) for at in states),
        max(abs(at.acceleration) for at in states),
        abs(travel),
        max(abs(at.turn_rate) for at in states),
        max(abs(at.turn_acceleration) for at in states),
        abs(heading),
        max(abs(at.speed * at.turn_rate) for at in states),
    )


def _larger(one: Extrema, other: Extrema) -> Extrema:
    return Extrema(*(max(a, b) for a, b in zip(vars(one).values(), vars(other).values(), strict=True)))
