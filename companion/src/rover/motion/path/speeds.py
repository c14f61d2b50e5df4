"""How fast each piece of a stretch is entered and left: one pass backward from the end, one forward from the start.

The curve of a corner is driven at one speed. On a line the acceleration is zero at both ends, and what a change of
speed takes in way is that of the jerk-limited profile, so that Ruckig finds a profile for every line. Along a bend the
acceleration goes on from node to node, with the fastest speeds that the limits of both axes allow, all nodes at once.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import rover_native
from numpy.typing import NDArray
from rover.motion.path.limits import DrivingLimits, change_distance
from rover.motion.path.piece import Chain, Piece
from rover.vehicle import Limits

Array = NDArray[np.float64]
Former = tuple[Sequence[Piece | Chain], Sequence[tuple[Array, Array]]]

# Metres of each line that a change of speed leaves unused, so that rounding never makes it impossible.
RESERVE_M = 2e-6
# The speed at the end of a bend that is lower by no more than this share is the one that was asked for.
SAME_SPEED = 2e-3


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


def part_speeds(
    parts: Sequence[Piece | Chain], limits: DrivingLimits, former: Former | None = None
) -> list[tuple[Array, Array]]:
    """Speeds and accelerations at the ends of each part of a stretch, and at the nodes of its bends (N + 1,).

    A bend takes the speed at its ends that the parts beside it leave it, or less; then these have less, too.
    `former`: parts and speeds of the same stretch, some of which may be driven slower now.
    """
    count = len(parts)
    joint = [0.0] * (count + 1)
    for number in range(1, count):
        joint[number] = min(_most(parts[number - 1], -1), _most(parts[number], 0), limits.travel.speed)
    solved: dict[int, tuple[Array, Array]] = {}
    changed = True
    while changed:
        for number in range(count - 1, -1, -1):
            joint[number] = _reached(parts[number], joint[number + 1], joint[number], limits.travel)
        for number in range(count):
            joint[number + 1] = _reached(parts[number], joint[number], joint[number + 1], limits.travel)
        changed = False
        for number, part in enumerate(parts):
            if not isinstance(part, Chain):
                continue
            ends = (joint[number], joint[number + 1])
            if number not in solved or any(solved[number][0][side] > ends[side] for side in (0, -1)):
                before = None if former is None else (former[0][number], former[1][number])
                solved[number] = _along(part, ends, limits, before)
                for side, at in ((0, number), (-1, number + 1)):
                    changed |= float(solved[number][0][side]) < joint[at]
                    joint[at] = float(solved[number][0][side])
    none = np.zeros(2)
    return [solved.get(number, (np.array(joint[number : number + 2]), none)) for number in range(count)]


def _most(part: Piece | Chain, end: int) -> float:
    return part.speed if isinstance(part, Piece) else float(part.most[end])


def _reached(part: Piece | Chain, here: float, there: float, limits: Limits) -> float:
    return there if isinstance(part, Chain) else min(there, _reach(part, here, there, limits))


def _along(
    chain: Chain,
    ends: tuple[float, float],
    limits: DrivingLimits,
    former: tuple[Piece | Chain, tuple[Array, Array]] | None,
) -> tuple[Array, Array]:
    """Speeds and accelerations at the nodes of a bend, with no more than `ends` where it begins and ends. `former`: the
    same bend before it was made slower, and its speeds."""
    begin = None
    if former is not None and isinstance(former[0], Chain):
        before, speeds = former
        if before is chain and (speeds[0][0], speeds[0][-1]) == ends:
            return speeds
        begin = (*_allowed(before, (float(speeds[0][0]), float(speeds[0][-1]))), speeds[0])
    most, share = _allowed(chain, ends)
    curvature, slope = chain.at_nodes()
    found, accelerations = rover_native.bend_speeds(
        chain.length, curvature, slope, chain.thirds[:, [0, -1]], most, share,
        (limits.travel.acceleration, limits.travel.jerk), (limits.heading.acceleration, limits.heading.jerk), begin,
    )  # fmt: skip
    for side, end in zip((0, -1), ends, strict=True):
        if found[side] > (1.0 - SAME_SPEED) * end:
            found[side] = end
    return found, accelerations


def _allowed(chain: Chain, ends: tuple[float, float]) -> tuple[Array, Array]:
    """The most speed at each node, and the share of the limits."""
    most = np.minimum(np.append(chain.most, ends[1]), np.append(ends[0], chain.most))
    return most, np.minimum(np.append(chain.share, 1.0), np.append(1.0, chain.share))


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
