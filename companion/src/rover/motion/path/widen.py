"""Makes room at the corners of a shortest path: it touches what it goes around, so no curve fits inside its corners.

A row of small corners around one thing becomes the one corner in which its outer legs meet, and a corner that is left
with less room beside it than it may be moved by is moved outward. Only where the footprint may be swept along the new
legs; everything else stays as it was.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np
import rover_native
from numpy.typing import NDArray
from rover.geometry import wrap_angle
from rover.motion.path.clearance import ClearanceMap

Array = NDArray[np.float64]
Point = tuple[float, float]
# A corner, and the first and the last corner of the old path that it stands for.
Corner = tuple[Point, int, int]

# Corners that are made one, at most, and what they turn by together at most, radians.
MAX_CORNERS = 12
MAX_TURN_RAD = math.radians(100.0)
# Corners that turn by less are driven through or rounded in millimetres.
MIN_TURN_RAD = math.radians(8.0)
# A corner is moved outward by these shares of what is allowed, the largest that is free.
SHARES = (1.0, 0.5, 0.25)
# Metres of a new leg that are compared with the old path at a time.
CHORD_M = 2e-3


def widened(
    path: Sequence[Point], clearance: ClearanceMap, most: float, slack: float = 0.0
) -> tuple[list[Point], Array]:
    """The polyline (N points) with room at its corners, and for each leg (N − 1,) how far from the old path it is.

    That is in metres, no less than the distance of any place on the leg from the part of `path` that it stands for. A
    corner that stands for many is at most `most` metres from one of them, and is then moved by at most `most`.
    `slack`: metres that the footprint is grown by where the new legs are checked. The ends stay.
    """
    old = [(float(x), float(y)) for x, y in path]
    corners = _joined(old, clearance, most, slack)
    points = [point for point, _, _ in corners]
    for number in range(1, len(points) - 1):
        before, here, behind = points[number - 1 : number + 2]
        turn = _turn(before, here, behind)
        if MIN_TURN_RAD <= abs(turn) <= MAX_TURN_RAD and float(clearance.margin(np.array([here]))[0]) < most:
            away = _heading(before, here) + turn / 2.0 - math.copysign(math.pi / 2.0, turn)
            for share in SHARES:
                moved = (here[0] + share * most * math.cos(away), here[1] + share * most * math.sin(away))
                if _clear([before, moved, behind], clearance, slack):
                    points[number] = moved
                    break
    return points, _apart(points, [(first, last) for _, first, last in corners], old)


def _apart(points: list[Point], stands: list[tuple[int, int]], old: list[Point]) -> Array:
    """What `widened` says of its legs. `stands`: for each point the corners of the old path that it stands for."""
    off = np.zeros(max(len(points) - 1, 0))
    same = [point == old[first] == old[last] for point, (first, last) in zip(points, stands, strict=True)]
    moved = [leg for leg in range(len(off)) if not (same[leg] and same[leg + 1])]
    if not moved:
        return off
    places, starts = [], [0]
    for leg in moved:
        count = max(1, math.ceil(math.dist(points[leg], points[leg + 1]) / CHORD_M))
        places.append(np.linspace(points[leg], points[leg + 1], count + 1))
        starts.append(starts[-1] + count + 1)
    way = np.concatenate(places)
    number = np.arange(len(way), dtype=np.int64)
    legs = np.array([(stands[leg][0], stands[leg + 1][1]) for leg in moved], dtype=np.int64)
    beside = rover_native.way_beside(
        (way, number, np.zeros(len(way) - 1)),
        (np.array(old), np.zeros(len(old) - 1)),
        np.array(starts[:-1], dtype=np.int64),
        legs,
    )
    # The chord from the end of one leg to the beginning of the next is none.
    off[moved] = [beside[begin : end - 1].max() for begin, end in itertools.pairwise(starts)]
    return off


def _joined(points: list[Point], clearance: ClearanceMap, most: float, slack: float) -> list[Corner]:
    """Rows of corners to the same side as one corner each."""
    if len(points) < 4:
        return [(point, number, number) for number, point in enumerate(points)]
    turns = [0.0, *(_turn(*points[number - 1 : number + 2]) for number in range(1, len(points) - 1)), 0.0]
    found: list[Corner] = [(points[0], 0, 0)]
    number = 1
    while number < len(points) - 1:
        last = number
        while last + 1 < min(len(points) - 1, number + MAX_CORNERS) and turns[last + 1] * turns[number] > 0.0:
            last += 1
        meeting = None
        while last > number and meeting is None:
            if abs(math.fsum(turns[number : last + 1])) <= MAX_TURN_RAD:
                meeting = _meeting(points, number, last, most)
                if meeting and not _clear([points[number], meeting, points[last]], clearance, slack):
                    meeting = None
            last -= meeting is None
        found.append((meeting or points[number], number, last))
        number = last + 1
    return [*found, (points[-1], len(points) - 1, len(points) - 1)]


def _meeting(points: list[Point], first: int, last: int, most: float) -> Point | None:
    """Where the leg to the first corner and the leg from the last meet beyond them; None when too far away."""
    (ax, ay), (bx, by) = points[first], points[last]
    a, b = _heading(points[first - 1], points[first]), _heading(points[last], points[last + 1])
    across = math.sin(b - a)
    if abs(across) < 1e-3:
        return None
    way = ((bx - ax) * math.sin(b) - (by - ay) * math.cos(b)) / across
    meeting = (ax + way * math.cos(a), ay + way * math.sin(a))
    near = min(math.dist(meeting, point) for point in points[first : last + 1])
    return meeting if way > 0.0 and near <= most else None


def _clear(points: Sequence[Point], clearance: ClearanceMap, slack: float) -> bool:
    line = np.array(points)
    return bool(clearance.swept(line[:-1], line[1:], np.full(len(line) - 1, slack)).all())


def _heading(a: Point, b: Point) -> float:
    return math.atan2(b[1] - a[1], b[0] - a[0])


def _turn(a: Point, b: Point, c: Point) -> float:
    return wrap_angle(_heading(b, c) - _heading(a, b))
