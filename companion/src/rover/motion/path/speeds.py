"""How fast each piece of a stretch is entered and left: one pass backward from the end, one forward from the start.

The curve of a corner is driven at one speed. On a line the acceleration is zero at both ends, and what a change of
speed takes in way is that of the jerk-limited profile, so that Ruckig finds a profile for every line. Along a bend the
acceleration goes on from node to node: there the two passes know acceleration only, and what they give is smoothed.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from rover.motion.path.limits import change_distance
from rover.motion.path.piece import Piece
from rover.vehicle import Limits

Array = NDArray[np.float64]

# Metres of each line that a change of speed leaves unused, so that rounding never makes it impossible.
RESERVE_M = 2e-6
# Places between two nodes of a bend at which its speed is smoothed, and how far towards its end that reaches.
PLACES, END_SHARE = 3, 0.35


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


def smooth_speeds(
    pieces: Sequence[Piece], limits: Limits, start: float = 0.0, end: float = 0.0
) -> tuple[list[float], list[float]]:
    """Speeds and accelerations (N + 1) at the ends of N pieces: those of `node_speeds`, smoothed along bends."""
    speeds = node_speeds(pieces, limits, start, end)
    accelerations = [0.0] * len(speeds)
    for bends, group in itertools.groupby(range(len(pieces)), key=lambda number: pieces[number].change is not None):
        numbers = list(group)
        if bends and len(numbers) > 1:
            first, last = numbers[0], numbers[-1] + 2
            smooth, slopes = _smoothed(pieces[first : last - 1], speeds[first:last])
            speeds[first:last], accelerations[first:last] = smooth, slopes
    return speeds, accelerations


def _reach(piece: Piece, here: float, there: float, limits: Limits) -> float:
    """The speed up to `there` at one end of a piece that can be changed to from `here` at its other end."""
    if there <= here:
        return there
    if not piece.parts:
        return fastest_within(here, there, max(0.999 * piece.length - RESERVE_M, 0.0), limits)
    if piece.change is None:
        return here
    acceleration = min(piece.change.acceleration, limits.acceleration)
    return min(there, max(here, piece.change.speed), math.sqrt(here * here + 2.0 * acceleration * piece.length))


def _smoothed(pieces: Sequence[Piece], speeds: Sequence[float]) -> tuple[list[float], list[float]]:
    """Speeds and accelerations at the nodes of a bend with a jerk that is limited.

    v²/2 changes along the way by the acceleration. Averaged over the way that is made in A / J, its slope changes by no
    more than J in time; the least within the same reach is averaged, so that no place becomes faster than it was.
    """
    length = np.array([piece.length for piece in pieces])
    time = np.array([piece.change.acceleration / piece.change.jerk for piece in pieces if piece.change is not None])
    nodes = np.concatenate([[0.0], np.cumsum(length)])
    share = np.arange(PLACES * len(pieces) + 1) / PLACES
    way = np.interp(share, np.arange(len(nodes)), nodes)
    energy = np.interp(way, nodes, np.square(speeds) / 2.0)
    at_node = np.maximum(np.append(time, 0.0), np.append(0.0, time))
    reach = 0.5 * np.sqrt(2.0 * energy) * np.interp(way, nodes, at_node)
    reach = np.minimum(reach, END_SHARE * np.minimum(way, way[-1] - way))
    least = lowest_within(way, energy, way - reach, way + reach)
    area = np.concatenate([[0.0], np.cumsum(np.diff(way) * (least[1:] + least[:-1]) / 2.0)])
    low, high = way - reach, way + reach
    wide = reach > 1e-6
    mean, slope = least.copy(), np.zeros(len(way))
    mean[wide] = (np.interp(high, way, area) - np.interp(low, way, area))[wide] / (high - low)[wide]
    slope[wide] = (np.interp(high, way, least) - np.interp(low, way, least))[wide] / (high - low)[wide]
    mean = np.minimum(mean, energy)
    slope[[0, -1]] = 0.0
    return np.sqrt(2.0 * mean[::PLACES]).tolist(), slope[::PLACES].tolist()


def lowest_within(at: Array, values: Array, low: Array, high: Array) -> Array:
    """The least of the values at ascending places between two bounds, (N,) each; every interval holds a place."""
    first, last = np.searchsorted(at, low, side="left"), np.searchsorted(at, high, side="right")
    last = np.maximum(last, first + 1)
    # Least of 1, 2, 4, … neighbours: any interval is covered by two of one size.
    level = np.log2(last - first).astype(np.int64)
    result = np.empty(len(at))
    runs = values
    for power in range(int(level.max(initial=0)) + 1):
        size = 1 << power
        here = level == power
        result[here] = np.minimum(runs[first[here]], runs[last[here] - size])
        if len(runs) > size:
            runs = np.minimum(runs[:-size], runs[size:])
    return result
