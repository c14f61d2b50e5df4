"""The controlled stop: from any state to rest within the limits, computed without Ruckig so that it can't fail."""

from __future__ import annotations

import math
from dataclasses import replace

from rover.motion.merge import merge
from rover.motion.profile import Profile
from rover.motion.segment import Segment, State
from rover.vehicle import Limits

# Residue of quantisation that is not worth a segment: the rest flag takes it to zero.
MIN_CHANGE = 1e-9


def stop_profile(speed: float, acceleration: float, limits: Limits) -> Profile:
    """Fastest way to rest, ignoring where that is: jerk, constant deceleration, jerk back.

    Acceleration a changes by ±J to a peak and back to 0; speed + the area under it is 0 at the end.
    """
    jerk, most = limits.jerk, limits.acceleration
    # Speed left when the acceleration alone is taken to zero decides which way to brake.
    left = speed + acceleration * abs(acceleration) / (2.0 * jerk)
    sign = -1.0 if left > 0.0 else 1.0
    if abs(left) < MIN_CHANGE and abs(acceleration) < MIN_CHANGE:
        return Profile((), 0.0, 0.0)
    # In the direction of braking: a is the acceleration, v the speed still to gain.
    a, v = sign * acceleration, -sign * speed
    lead: tuple[tuple[float, float], ...] = ()
    if a > most:
        # Beyond the limit: back to it first.
        first = (a - most) / jerk
        v -= (a + most) / 2.0 * first
        lead, a = ((first, -sign * jerk),), most
    # Peak p from (p² − a²)/2J + p²/2J = v.
    peak = math.sqrt(max(jerk * v + a * a / 2.0, 0.0))
    flat = 0.0
    if peak > most:
        flat = (v - (2.0 * most * most - a * a) / (2.0 * jerk)) / most
        peak = most
    rise = max((peak - a) / jerk, 0.0)
    pieces = (*lead, (rise, sign * jerk), (max(flat, 0.0), 0.0), (peak / jerk, -sign * jerk))
    return Profile(tuple((t, j) for t, j in pieces if t > 0.0), 0.0, 0.0)


def stop_distance(speed: float, acceleration: float, limits: Limits) -> float:
    """Metres that the fastest stop takes."""
    position, v, a = 0.0, speed, acceleration
    for t, jerk in stop_profile(speed, acceleration, limits).pieces:
        position += t * (v + t * (a / 2.0 + t * jerk / 6.0))
        v += t * (a + t * jerk / 2.0)
        a += t * jerk
    return position


def stop_segments(state: State, travel: Limits, heading: Limits) -> list[Segment]:
    """Segments from `state` to rest; a single idle one when it is at rest already but for quantisation."""
    segments = merge(
        stop_profile(state.speed, state.acceleration, travel),
        stop_profile(state.turn_rate, state.turn_acceleration, heading),
    )
    if not segments:
        segments = [Segment(1_000, 0, 0)]
    return [*segments[:-1], replace(segments[-1], rest=True)]
