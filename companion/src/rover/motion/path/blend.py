"""Rounds a polyline's corners inside measured clearance; corners that can't be rounded are turned on the spot.

Pure: polyline, limits and clearance in; stretches of lines and curves out, each of which begins and ends at rest.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from rover.errors import BadInput
from rover.motion.path import corner
from rover.motion.path.clearance import ClearanceMap
from rover.motion.path.limits import DrivingLimits, change_distance

Array = NDArray[np.float64]

# Chords that stand for a curve where it is checked against the map.
CHORDS = 16
# However short the way to a slower corner, a curve keeps this share of its length.
MIN_SHARE = 0.5
# Lines are cut into parts of at most so many metres for a speed that depends on the clearance.
MAX_SPEED_STEP_M = 0.05
# A curve that touches something is tried at these shares of its length.
LENGTH_SHARES = (1.0, 0.85, 0.7, 0.6, 0.5, 0.42, 0.35, 0.29, 0.24, 0.2, 0.16, 0.13)


@dataclass(frozen=True)
class BlendSettings:
    """`max_cut`: metres between a corner and the curve that rounds it; `max_angle`: radians, beyond it a corner is
    turned on the spot; `shortest`: legs shorter than this are dropped, and so much of each leg stays straight.
    `kink`: radians, a corner without room that turns by less is driven through as it is.
    `slack`: metres that the footprint is grown by where a curve is checked, for what following it may be off by.
    """

    max_cut: float = 0.05
    max_angle: float = math.radians(120.0)
    shortest: float = 0.004
    slack: float = 2e-4
    kink: float = 0.0


@dataclass(frozen=True, slots=True)
class Piece:
    """A straight line (`angle` 0) or a curve of corner.py that turns by `angle` radians, left positive.

    Begins at (x, y) in `heading`; `speed` is the most that it may be driven at, `bound` what clearance and sight alone
    allow, whatever the limits of the axes. `shape`: of corner.py, for a curve.
    """

    x: float
    y: float
    heading: float
    length: float
    angle: float
    speed: float
    bound: float
    shape: int = 0

    def curvature(self, s: float) -> float:
        """1/m at arc length `s` from its beginning."""
        if self.angle == 0.0:
            return 0.0
        return self.angle / self.length * corner.derivatives(s / self.length, self.shape)[1]


@dataclass(frozen=True)
class Stretch:
    """Pieces driven without a stop; before it the rover turns on the spot to the heading of the first."""

    pieces: tuple[Piece, ...]

    @property
    def length(self) -> float:
        """Metres."""
        return sum(piece.length for piece in self.pieces)


def blend_path(
    path: ArrayLike, limits: DrivingLimits, settings: BlendSettings | None = None, clearance: ClearanceMap | None = None
) -> list[Stretch]:
    """The polyline (N, 2) with its corners rounded; empty when it leads nowhere.

    Without `clearance` the cut alone bounds a corner. Raises BadInput when the path is no finite polyline.
    """
    settings = settings or BlendSettings()
    points = _distinct(path, settings.shortest)
    if len(points) < 2:
        return []
    legs = np.diff(points, axis=0)
    lengths = np.hypot(legs[:, 0], legs[:, 1])
    headings = np.arctan2(legs[:, 1], legs[:, 0])
    angles = np.mod(np.diff(headings) + math.pi, 2.0 * math.pi) - math.pi
    shape = limits.corner_shape(angles)
    curve, speed = _curves(points, lengths, headings, angles, shape, limits, settings, clearance)
    taken = np.zeros(len(angles))
    rounded = curve > 0.0
    if rounded.any():
        taken[rounded] = curve[rounded] * corner.tangent_and_cut(angles[rounded], shape[rounded])[0]
    bound = np.minimum(limits.travel.speed, limits.sight_speed(angles, np.maximum(curve, 1e-9), shape))
    if clearance is not None and limits.clearance_time > 0.0 and rounded.any():
        bound = np.minimum(bound, _clearance_at(points, legs, lengths, taken, limits, clearance))
    turns = (angles, curve, taken, np.minimum(speed, bound), bound, shape)
    return _assemble(points, headings, lengths, turns, settings.kink, limits, clearance)


def _distinct(path: ArrayLike, shortest: float) -> Array:
    """The path without legs shorter than `shortest`; its last point stays."""
    try:
        points = np.asarray(path, dtype=np.float64)
    except (TypeError, ValueError):
        raise BadInput("the path must be a list of points [x, y] in metres") from None
    if points.size == 0:
        return np.empty((0, 2))
    if points.ndim != 2 or points.shape[1] != 2:
        raise BadInput("the path must be a list of points [x, y] in metres")
    if not np.isfinite(points).all():
        raise BadInput(f"point {int(np.argmin(np.isfinite(points).all(axis=1))) + 1} of the path is not finite")
    steps = np.hypot(*np.diff(points, axis=0).T)
    if len(steps) and steps.min() >= shortest:
        return points
    kept = [points[0]]
    for point in points[1:]:
        if math.dist(kept[-1], point) >= shortest:
            kept.append(point)
    if math.dist(kept[-1], points[-1]) > 0.0 and len(kept) > 1:
        kept[-1] = points[-1]
    return np.array(kept)


def _curves(
    points: Array,
    lengths: Array,
    headings: Array,
    angles: Array,
    shape: corner.Shapes,
    limits: DrivingLimits,
    settings: BlendSettings,
    clearance: ClearanceMap | None,
) -> tuple[Array, Array]:
    """Length of the curve at each corner, 0 where it is turned on the spot, and the speed on it."""
    size = np.abs(angles)
    wanted = (size <= settings.max_angle) & (settings.max_cut > 0.0)
    tangent, cut = corner.tangent_and_cut(np.where(wanted, size, 0.0), shape)
    # As long as full speed needs, as long as the cut allows, and as long as both legs have room for.
    length = np.minimum(np.maximum(limits.corner_length(size, shape), 0.01), settings.max_cut / np.maximum(cut, 1e-12))
    length = np.where(wanted, length, 0.0)
    need = length * tangent
    # Beside a place of rest a curve leaves room to reach its speed: a curve is driven at one speed.
    at_rest = np.concatenate([[True], ~wanted, [True]])
    start = change_distance(0.0, limits.travel.speed, limits.travel)
    straight = np.where(at_rest[:-1] | at_rest[1:], np.minimum(start, 0.5 * lengths), 0.0)
    room = np.maximum(lengths - np.maximum(straight, settings.shortest), 0.0)
    demand = np.concatenate([[0.0], need]) + np.concatenate([need, [0.0]])
    share = np.minimum(room / np.maximum(demand, 1e-12), 1.0)
    length = length * np.minimum(share[:-1], share[1:])
    speed = limits.corner_speed(size, np.maximum(length, 1e-9), shape)
    length = length * _room_for_braking(lengths, length * tangent, speed, limits)
    speed = limits.corner_speed(size, np.maximum(length, 1e-9), shape)
    if clearance is not None:
        length, speed = _shrink(points, headings, angles, shape, length, speed, tangent, limits, settings, clearance)
    length = np.where(speed >= limits.min_speed, length, 0.0)
    return length, speed


def _room_for_braking(lengths: Array, taken: Array, speed: Array, limits: DrivingLimits) -> Array:
    """Share of its length that each curve keeps, so that between it and a slower one the speed can change."""
    keep = np.ones(len(taken))
    for leg in range(1, len(lengths) - 1):
        slow, fast = (leg - 1, leg) if speed[leg - 1] < speed[leg] else (leg, leg - 1)
        if taken[slow] > 0.0 and taken[fast] > 0.0:
            change = change_distance(float(speed[slow]), float(speed[fast]), limits.travel)
            missing = taken[slow] + taken[fast] + change - lengths[leg]
            if missing > 0.0:
                keep[fast] = min(keep[fast], max(1.0 - missing / taken[fast], MIN_SHARE))
    return keep


def _shrink(
    points: Array,
    headings: Array,
    angles: Array,
    shape: corner.Shapes,
    length: Array,
    speed: Array,
    tangent: Array,
    limits: DrivingLimits,
    settings: BlendSettings,
    clearance: ClearanceMap,
) -> tuple[Array, Array]:
    """Each curve at the largest share of its length at which the footprint on it stays clear; 0 where none does."""
    result, fastest = np.zeros_like(length), np.zeros_like(speed)
    left = np.flatnonzero((length > 0.0) & (speed >= limits.min_speed))
    for share in LENGTH_SHARES:
        if not len(left):
            break
        trial = length[left] * share
        clear = _clear(
            points[left + 1], headings[left], angles[left], shape[left], trial, tangent[left], settings, clearance
        )
        result[left[clear]] = trial[clear]
        left = left[~clear]
    done = result > 0.0
    fastest[done] = limits.corner_speed(angles[done], result[done], shape[done])
    return result, fastest


def _clear(
    at: Array,
    heading: Array,
    angle: Array,
    shape: corner.Shapes,
    length: Array,
    tangent: Array,
    settings: BlendSettings,
    clearance: ClearanceMap,
) -> NDArray[np.bool_]:
    """True for curves along which the disc touches nothing: chords, and how far the curve bulges beyond them."""
    back = length * tangent
    x, y = at[:, 0] - back * np.cos(heading), at[:, 1] - back * np.sin(heading)
    curve = corner.points(x, y, heading, angle, length, shape, CHORDS)
    bulge = corner.PEAK_CURVATURE[shape] * np.abs(angle) * length / (8.0 * CHORDS**2)
    a, b = curve[:, :-1].reshape(-1, 2), curve[:, 1:].reshape(-1, 2)
    swept = clearance.swept(a, b, np.repeat(bulge + settings.slack, CHORDS))
    return np.asarray(swept.reshape(-1, CHORDS).all(axis=1), dtype=np.bool_)


def _clearance_at(
    points: Array, legs: Array, lengths: Array, taken: Array, limits: DrivingLimits, clearance: ClearanceMap
) -> Array:
    """Most speed at each corner by the margin there: at its ends and at the corner itself."""
    unit = legs / lengths[:, None]
    at = points[1:-1]
    ends = np.concatenate([at, at - unit[:-1] * taken[:, None], at + unit[1:] * taken[:, None]])
    margin = clearance.margin(ends).reshape(3, -1).min(axis=0)
    return limits.clearance_speed(margin)


def _line_speeds(
    start: Array, end: Array, length: float, limits: DrivingLimits, clearance: ClearanceMap
) -> list[float]:
    """Speeds by the clearance in the middle of equal parts of a line, none longer than MAX_SPEED_STEP_M."""
    parts = max(1, math.ceil(length / MAX_SPEED_STEP_M))
    share = (np.arange(parts)[:, None] + 0.5) / parts
    speeds: list[float] = limits.clearance_speed(clearance.margin(start + share * (end - start))).tolist()
    return speeds


def _assemble(
    points: Array,
    headings: Array,
    lengths: Array,
    turns: tuple[Array, Array, Array, Array, Array, corner.Shapes],
    kink: float,
    limits: DrivingLimits,
    clearance: ClearanceMap | None,
) -> list[Stretch]:
    """Lines and curves in order, cut into stretches where the rover turns on the spot.

    `turns`: of each corner the angle, the length of its curve, what that takes of each leg, speed, bound and shape.
    """
    angles, curve, taken, speed, bound, shape = turns
    before = np.concatenate([[0.0], taken])
    after = np.concatenate([taken, [0.0]])
    unit_x, unit_y = np.cos(headings), np.sin(headings)
    begin_x, begin_y = points[:-1, 0] + before * unit_x, points[:-1, 1] + before * unit_y
    rest = lengths - before - after
    end_x, end_y = begin_x + rest * unit_x, begin_y + rest * unit_y
    bounded = clearance is not None and limits.clearance_time > 0.0
    stretches: list[Stretch] = []
    pieces: list[Piece] = []
    columns = (begin_x, begin_y, headings, rest, end_x, end_y)
    at_end = (np.append(angles, math.inf), *(np.append(each, 0) for each in (curve, speed, bound, shape)))
    rows = zip(*(column.tolist() for column in (*columns, *at_end)), strict=True)
    for x, y, heading, length, x1, y1, angle, bend, v, ground_speed, form in rows:
        if length > 1e-9:
            if bounded:
                assert clearance is not None
                stepwise = _line_speeds(np.array([x, y]), np.array([x1, y1]), length, limits, clearance)
                pieces += _line_parts(x, y, heading, length, stepwise)
            else:
                pieces.append(Piece(x, y, heading, length, 0.0, limits.travel.speed, limits.travel.speed))
        if bend > 0.0:
            pieces.append(Piece(x1, y1, heading, bend, angle, v, ground_speed, form))
        elif abs(angle) > kink:
            stretches.append(Stretch(tuple(pieces)))
            pieces = []
    return stretches


def _line_parts(x: float, y: float, heading: float, length: float, speeds: list[float]) -> list[Piece]:
    """A line in parts of equal length, neighbours of the same speed joined."""
    parts: list[Piece] = []
    step = length / len(speeds)
    begin = 0
    for number in range(1, len(speeds) + 1):
        if number == len(speeds) or speeds[number] != speeds[begin]:
            way = begin * step
            at_x, at_y = x + way * math.cos(heading), y + way * math.sin(heading)
            parts.append(Piece(at_x, at_y, heading, (number - begin) * step, 0.0, speeds[begin], speeds[begin]))
            begin = number
    return parts
