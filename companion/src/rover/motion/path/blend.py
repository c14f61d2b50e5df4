"""A polyline to what can be driven without a stop: lines, curves around single corners, bends through runs of them.

Pure: polyline, limits and clearance in; stretches of lines and curves out, each of which begins and ends at rest. The
rover turns on the spot only at corners that are too sharp, or that have no room.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from rover.motion.path import corner
from rover.motion.path.bend import Bend, Run, bends, widest_window
from rover.motion.path.clearance import ClearanceMap
from rover.motion.path.condition import distinct, finite_points, simplified
from rover.motion.path.limits import DrivingLimits
from rover.motion.path.piece import Chain, Piece, Stretch
from rover.motion.path.rounding import BlendSettings, Corners, Curves, Polygon, round_corners
from rover.motion.path.widen import widened

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
KnownBends = dict[tuple[int, int], tuple[Run, Bend]]

# Lines are cut into parts of at most so many metres for a speed that depends on the clearance.
MAX_SPEED_STEP_M = 0.05
# Share of the tolerance that points may be left out by; no more than so many metres.
SIMPLIFY_SHARE, MAX_SIMPLIFY_M = 0.02, 1e-3
# Shorter legs are none.
MIN_LEG_M = 1e-6
# Corners are one bend where the legs between are shorter than this times what their curves would take of them.
JOIN = 1.4
# So often a bend is divided where it has no room, or where it is slower than the lowest speed for so many seconds:
# about what a turn on the spot takes with braking before it and starting after it.
MAX_DIVISIONS, MAX_CREEP_S = 12, 1.5


@dataclass(frozen=True, eq=False)
class Blend:
    """`stretches`, and the conditioned polyline that they were made from: `points` (N, 2), and how far the points that
    each leg leaves out are from it, `error` (N − 1,), metres."""

    stretches: list[Stretch]
    points: Array
    error: Array


def blend_path(
    path: ArrayLike,
    limits: DrivingLimits,
    settings: BlendSettings | None = None,
    clearance: ClearanceMap | None = None,
    sharp: Collection[int] = (),
) -> Blend:
    """The polyline (N, 2) as stretches, none when it leads nowhere.

    Without `clearance` the cut alone bounds a curve. `sharp`: points of the conditioned polyline at which the rover
    turns on the spot. Raises BadInput when the path is no finite polyline.
    """
    settings = settings or BlendSettings()
    points = distinct(finite_points(path), MIN_LEG_M)
    points, error = simplified(points, min(SIMPLIFY_SHARE * settings.max_cut, MAX_SIMPLIFY_M), clearance)
    if clearance is not None and settings.widen > 0.0 and len(points) > 2:
        points, error = _with_room(points, error, settings, clearance)
    if len(points) < 2:
        return Blend([], points, error)
    line = Polygon.of(points, error, settings.max_cut)
    at_rest = np.zeros(len(line.angles), dtype=bool)
    at_rest[[number - 1 for number in sharp]] = True
    alone = at_rest.copy()
    known: KnownBends = {}
    for _ in range(MAX_DIVISIONS):
        stretches, slow = _blended(line, at_rest, alone, limits, settings, clearance, known)
        if not slow:
            break
        alone[slow] = True
        at_rest[slow] |= ~_roomy(line, limits)[slow]
    return Blend(stretches, points, error)


def _roomy(line: Polygon, limits: DrivingLimits) -> Flags:
    """True for corners that have a curve of their own in half of the legs beside them, at the lowest speed or more."""
    half = np.minimum(line.lengths[:-1], line.lengths[1:]) / 2.0
    shape = limits.corner_shape(line.angles)
    tangent, cut = corner.tangent_and_cut(np.minimum(np.abs(line.angles), 3.0), shape)
    length = np.minimum(half / tangent, line.tolerance / np.maximum(cut, 1e-12))
    speed = limits.corner_speed(line.angles, np.maximum(length, 1e-9), shape)
    return np.asarray(speed >= limits.min_speed, dtype=np.bool_)


def _with_room(points: Array, error: Array, settings: BlendSettings, clearance: ClearanceMap) -> tuple[Array, Array]:
    """The polyline with room at its corners, and how far each of its legs is from where it was at most."""
    wide, off = widened(points.tolist(), clearance, settings.widen, settings.slack)
    return np.array(wide), off + error.max(initial=0.0)


def _blended(
    line: Polygon,
    at_rest: Flags,
    alone: Flags,
    limits: DrivingLimits,
    settings: BlendSettings,
    clearance: ClearanceMap | None,
    known: KnownBends,
) -> tuple[list[Stretch], list[int]]:
    """The stretches, and corners at which bends are too slow or have no room: `alone` they may have some, or be turned
    on the spot. `known`: bends that were found before, by their corners."""
    corners = Corners.of(line, at_rest, limits, settings)
    spans = _runs(line, corners, alone)
    in_run = np.zeros(len(line.angles), dtype=bool)
    for first, last in spans:
        in_run[first : last + 1] = True
    # What bends take of the legs before and behind each corner.
    taken = np.zeros((len(line.angles), 2))
    runs = [_run(line, corners, in_run, taken, first, last, limits) for first, last in spans]
    new = [not (span in known and known[span][0] == run) for span, run in zip(spans, runs, strict=True)]
    fresh = bends(list(itertools.compress(runs, new)), limits, clearance, settings.slack)
    pairs = zip(itertools.compress(runs, new), fresh, strict=True)
    known.update(zip(itertools.compress(spans, new), pairs, strict=True))
    found = [known[span][1] for span in spans]
    slow: list[int] = []
    for (first, _), run, bend in zip(spans, runs, found, strict=True):
        slow += [first + number for number in _slow_vertices(run, bend, limits.min_speed)]
    curves = round_corners(line, corners, ~in_run, taken, limits, settings, clearance)
    inside = {first: (last, bend.chain) for (first, last), bend in zip(spans, found, strict=True)}
    return _assemble(line, curves, taken, inside, settings.kink, limits, clearance), slow


def _runs(line: Polygon, corners: Corners, alone: Flags) -> list[tuple[int, int]]:
    """First and last corner of each run: neighbours whose curves would overlap on the leg between them."""
    joined = (JOIN * (corners.room[:-1] + corners.room[1:]) > line.lengths[1:-1]) & ~(alone[:-1] | alone[1:])
    edges = np.diff(np.concatenate([[0], joined.astype(np.int64), [0]]))
    return list(zip(np.flatnonzero(edges == 1).tolist(), np.flatnonzero(edges == -1).tolist(), strict=True))


def _run(
    line: Polygon, corners: Corners, in_run: Flags, taken: Array, first: int, last: int, limits: DrivingLimits
) -> Run:
    """The run's points from the beginning of its bend to the end; notes in `taken` what it takes of the outer legs."""
    widest = widest_window(limits)
    pinned = []
    for side, (number, beyond, leg) in enumerate(((first, first - 1, first), (last, last + 1, last + 1))):
        length = float(line.lengths[leg])
        ends_at_rest = not 0 <= beyond < len(line.angles) or bool(corners.stops[beyond])
        pinned.append(ends_at_rest and length <= widest)
        if pinned[-1]:
            taken[number, side] = length
        elif ends_at_rest:
            taken[number, side] = min(widest, 0.7 * length)
        else:
            room, other = float(corners.room[number]), float(corners.room[beyond])
            share = length * room / (room + other)
            if not in_run[beyond]:
                share = max(share, length - other)
            taken[number, side] = min(widest, 0.95 * share)
    begin, end = line.points[first + 1], line.points[last + 1]
    before = begin - line.legs[first] * (taken[first, 0] / line.lengths[first])
    behind = end + line.legs[last + 1] * (taken[last, 1] / line.lengths[last + 1])
    points = np.concatenate([[before], line.points[first + 1 : last + 2], [behind]])
    return Run(points, (pinned[0], pinned[1]), float(line.tolerance[first : last + 1].min()), first)


def _slow_vertices(run: Run, bend: Bend, min_speed: float) -> list[int]:
    """For each row of curves that are too slow for too long, the vertex of the run nearest to the slowest."""
    speeds, length = bend.chain.speed, bend.chain.length
    edges = np.diff(np.concatenate([[0], (speeds < min_speed).astype(np.int64), [0]]))
    way = run.way[1:-1]
    found = []
    for low, high in zip(np.flatnonzero(edges == 1).tolist(), np.flatnonzero(edges == -1).tolist(), strict=True):
        if (length[low:high] / np.maximum(speeds[low:high], 1e-9)).sum() < MAX_CREEP_S:
            continue
        worst = low + int(np.argmin(speeds[low:high]))
        found.append(int(np.argmin(np.abs(way - (bend.begin[worst] + bend.end[worst]) / 2.0))))
    return found


def _line_speeds(
    start: Array, end: Array, length: float, limits: DrivingLimits, clearance: ClearanceMap
) -> list[float]:
    """Speeds by the clearance in the middle of equal parts of a line, none longer than MAX_SPEED_STEP_M."""
    parts = max(1, math.ceil(length / MAX_SPEED_STEP_M))
    share = (np.arange(parts)[:, None] + 0.5) / parts
    speeds: list[float] = limits.clearance_speed(clearance.margin(start + share * (end - start))).tolist()
    return speeds


def _assemble(
    line: Polygon,
    curves: Curves,
    taken: Array,
    inside: dict[int, tuple[int, Chain]],
    kink: float,
    limits: DrivingLimits,
    clearance: ClearanceMap | None,
) -> list[Stretch]:
    """Lines, curves and bends in order, cut into stretches where the rover turns on the spot.

    `inside`: for the first corner of each run its last corner and its curves.
    """
    taken = taken + curves.taken[:, None]
    before, after = taken[:, 0].tolist(), taken[:, 1].tolist()
    points, headings, lengths = line.points.tolist(), line.headings.tolist(), line.lengths.tolist()
    angles, bend = line.angles.tolist(), curves.length.tolist()
    speed, bound, shape = curves.speed.tolist(), curves.bound.tolist(), curves.shape.tolist()
    most = limits.travel.speed
    stretches: list[Stretch] = []
    pieces: list[Piece | Chain] = []
    leg, used = 0, 0.0
    while leg < len(lengths):
        heading = headings[leg]
        unit_x, unit_y = math.cos(heading), math.sin(heading)
        x, y = points[leg][0] + used * unit_x, points[leg][1] + used * unit_y
        rest = lengths[leg] - used - (before[leg] if leg < len(angles) else 0.0)
        if rest > 1e-9:
            if clearance is not None and limits.clearance_time > 0.0:
                end = np.array([x + rest * unit_x, y + rest * unit_y])
                pieces += _line_parts(
                    x, y, heading, rest, _line_speeds(np.array([x, y]), end, rest, limits, clearance), leg
                )
            else:
                pieces.append(Piece(x, y, heading, rest, 0.0, most, most, leg=leg))
        if leg == len(angles):
            break
        number = leg
        if number in inside:
            number, bent = inside[number]
            pieces.append(bent)
        elif bend[number] > 0.0:
            x, y = x + max(rest, 0.0) * unit_x, y + max(rest, 0.0) * unit_y
            parts = corner.parts(angles[number], bend[number], shape[number])
            pieces.append(
                Piece(x, y, heading, bend[number], angles[number], speed[number], bound[number], parts, leg=leg)
            )
        elif abs(angles[number]) > kink:
            stretches.append(Stretch(tuple(pieces)))
            pieces = []
        leg, used = number + 1, after[number]
    if pieces:
        stretches.append(Stretch(tuple(pieces)))
    return [stretch for stretch in stretches if stretch.parts]


def _line_parts(x: float, y: float, heading: float, length: float, speeds: list[float], leg: int) -> list[Piece]:
    """A line in parts of equal length, neighbours of the same speed joined."""
    parts: list[Piece] = []
    step = length / len(speeds)
    begin = 0
    for number in range(1, len(speeds) + 1):
        if number == len(speeds) or speeds[number] != speeds[begin]:
            way = begin * step
            at_x, at_y = x + way * math.cos(heading), y + way * math.sin(heading)
            parts.append(
                Piece(at_x, at_y, heading, (number - begin) * step, 0.0, speeds[begin], speeds[begin], leg=leg)
            )
            begin = number
    return parts
