"""How fast each piece of a stretch is entered and left: one pass backward from the end, one forward from the start.

Between pieces the acceleration is zero. A curve is driven at one speed. What a change of speed takes in way is that of
the jerk-limited profile between the two speeds, so that Ruckig finds a profile for every line.
"""

from __future__ import annotations

from collections.abc import Sequence

from rover.motion.path.blend import Piece
from rover.motion.path.limits import change_distance
from rover.vehicle import Limits

# Metres of each line that a change of speed leaves unused, so that rounding never makes it impossible.
RESERVE_M = 2e-6


def fastest_within(slow: float, most: float, distance: float, limits: Limits) -> float:
    """The greatest speed up to `most` that can be reached from `slow` within `distance`."""
    if most <= slow or change_distance(slow, most, limits) <= distance:
        return most
    low, high = slow, most
    for _ in range(26):
        middle = 0.5 * (low + high)
        if change_distance(slow, middle, limits) <= distance:
            low = middle
        else:
            high = middle
    return low


def node_speeds(pieces: Sequence[Piece], limits: Limits, start: float = 0.0, end: float = 0.0) -> list[float]:
    """Speeds (N + 1) at the ends of N pieces.

    `start` is what it is; where it is too fast for what follows, the speeds after it are what braking allows.
    """
    count = len(pieces)
    speeds = [start] * (count + 1)
    for number in range(1, count):
        speeds[number] = min(pieces[number - 1].speed, pieces[number].speed, limits.speed)
    speeds[count] = min(end, pieces[-1].speed, limits.speed) if count else end
    for number in range(count - 1, -1, -1):
        speeds[number] = min(speeds[number], _reach(pieces[number], speeds[number + 1], speeds[number], limits))
    for number in range(count):
        speeds[number + 1] = min(speeds[number + 1], _reach(pieces[number], speeds[number], speeds[number + 1], limits))
    return speeds


def _reach(piece: Piece, here: float, there: float, limits: Limits) -> float:
    if there <= here:
        return there
    if piece.angle != 0.0:
        return here
    return fastest_within(here, there, max(0.999 * piece.length - RESERVE_M, 0.0), limits)
