"""How fast each piece of a stretch is entered and left: one pass backward from the end, one forward from the start.

The curve of a corner is driven at one speed. On a line the acceleration is zero at both ends, and what a change of
speed takes in way is that of the jerk-limited profile, so that Ruckig finds a profile for every line. Along a bend the
acceleration goes on from node to node, with the fastest speeds that the limits of both axes allow, all nodes at once.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Sequence

import numpy as np
import rover_native
from numpy.typing import NDArray
from rover.motion.path.limits import DrivingLimits, change_distance
from rover.motion.path.piece import Chain, Piece
from rover.vehicle import Limits

Array = NDArray[np.float64]

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


class PartSpeeds:
    """Speeds and accelerations at the ends of each part of a stretch, and at the nodes of its bends (N + 1,).

    A bend takes the speed at its ends that the parts beside it leave it, or less; then these have less, too.
    """

    def __init__(self, parts: Sequence[Piece | Chain], limits: DrivingLimits) -> None:
        self.parts = list(parts)
        self.limits = limits
        count = len(self.parts)
        self._joint = [0.0] * (count + 1)
        for number in range(1, count):
            before, behind = self.parts[number - 1], self.parts[number]
            self._joint[number] = min(_most(before, -1), _most(behind, 0), limits.travel.speed)
        self._bends: dict[int, tuple[Array, Array]] = {}
        self._settle(range(count - 1, -1, -1))
        self._settle(range(count))

    def __getitem__(self, number: int) -> tuple[Array, Array]:
        return self._bends.get(number) or (np.array(self._joint[number : number + 2]), np.zeros(2))

    def slower(self, number: int, part: Piece | Chain) -> tuple[int, int]:
        """Another part in the place of one that was faster; the first part whose speeds differ now, and the first curve
        of it."""
        before = self.parts[number]
        self.parts[number] = part
        changed = [number]
        old = self._bends.get(number)
        if isinstance(part, Chain) and isinstance(before, Chain) and old is not None:
            begin = (*_allowed(before, (float(old[0][0]), float(old[0][-1]))), old[0])
            self._bends[number] = _along(part, (self._joint[number], self._joint[number + 1]), self.limits, begin)
            self._see_ends(number, changed)
        else:
            for joint, end in ((number, 0), (number + 1, -1)):
                self._lower(joint, _most(part, end), changed)
        self._settle(list(changed), changed)
        first = min(changed)
        new = self._bends.get(number)
        if first < number or old is None or new is None:
            return first, 0
        differs = (old[0] != new[0]) | (old[1] != new[1])
        return number, max(int(np.argmax(differs)) - 1, 0)

    def _settle(self, numbers: Iterable[int], changed: list[int] | None = None) -> None:
        """Until no part is entered or left faster than it allows; `changed` grows by parts with other speeds."""
        changed = [] if changed is None else changed
        waiting = deque(numbers)
        while waiting:
            number = waiting.popleft()
            part, known = self.parts[number], len(changed)
            begin, end = self._joint[number], self._joint[number + 1]
            if isinstance(part, Piece):
                self._lower(number, _reach(part, end, begin, self.limits.travel), changed)
                self._lower(number + 1, _reach(part, begin, end, self.limits.travel), changed)
            else:
                speeds = self._bends.get(number)
                if speeds is None or speeds[0][0] > begin or speeds[0][-1] > end:
                    self._bends[number] = _along(part, (begin, end), self.limits, None)
                    changed.append(number)
                self._see_ends(number, changed)
            waiting.extend(changed[known:])

    def _see_ends(self, number: int, changed: list[int]) -> None:
        speeds = self._bends[number][0]
        self._lower(number, float(speeds[0]), changed)
        self._lower(number + 1, float(speeds[-1]), changed)

    def _lower(self, joint: int, speed: float, changed: list[int]) -> None:
        if speed < self._joint[joint]:
            self._joint[joint] = speed
            changed += [number for number in (joint - 1, joint) if 0 <= number < len(self.parts)]


def _most(part: Piece | Chain, end: int) -> float:
    return part.speed if isinstance(part, Piece) else float(part.most[end])


def _along(
    chain: Chain, ends: tuple[float, float], limits: DrivingLimits, former: tuple[Array, Array, Array] | None
) -> tuple[Array, Array]:
    """Speeds and accelerations at the nodes of a bend, with no more than `ends` where it begins and ends. `former`:
    most speed, share and speed at its nodes before it was made slower."""
    most, share = _allowed(chain, ends)
    curvature, slope = chain.nodes
    found, accelerations = rover_native.bend_speeds(
        chain.length, curvature, slope, chain.thirds[:, [0, -1]], most, share,
        (limits.travel.acceleration, limits.travel.jerk), (limits.heading.acceleration, limits.heading.jerk), former,
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
