"""Curves around single corners: as long as full speed needs, and no longer than tolerance, legs and clearance allow."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from rover.motion.path import corner
from rover.motion.path.clearance import ClearanceMap
from rover.motion.path.limits import DrivingLimits, change_distance

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

# Chords that stand for a curve where it is checked against the map.
CHORDS = 16
# However short the way to a slower corner, a curve keeps this share of its length.
MIN_SHARE = 0.5
# A curve that touches something is tried at these shares of its length.
LENGTH_SHARES = (1.0, 0.85, 0.7, 0.6, 0.5, 0.42, 0.35, 0.29, 0.24, 0.2, 0.16, 0.13)


@dataclass(frozen=True)
class BlendSettings:
    """`max_cut`: metres that curves may be off the polyline; `max_angle`: radians, beyond it a corner is turned on the
    spot; `min_leg`: legs shorter than this are dropped, and so much of each leg stays straight.
    `kink`: radians, a corner without room that turns by less is driven through as it is.
    `slack`: metres that the footprint is grown by where a curve is checked, for what following it may be off by.
    `widen`: metres that corners may be moved outward by, with a map, to make room for curves.
    """

    max_cut: float = 0.05
    max_angle: float = math.radians(120.0)
    min_leg: float = 0.004
    slack: float = 2e-4
    kink: float = 0.0
    widen: float = 0.0


@dataclass(frozen=True, eq=False)
class Polygon:
    """`points` (N, 2), of the legs (N − 1) vectors, lengths and headings, of the corners (N − 2) the angles and the
    tolerance: how far curves there may be off, metres."""

    points: Array
    legs: Array
    lengths: Array
    headings: Array
    angles: Array
    tolerance: Array

    @classmethod
    def of(cls, points: Array, error: Array, max_cut: float) -> Polygon:
        """`error` (N − 1): how far the points that each leg leaves out are from it already."""
        legs = np.diff(points, axis=0)
        headings = np.arctan2(legs[:, 1], legs[:, 0])
        angles = np.mod(np.diff(headings) + math.pi, 2.0 * math.pi) - math.pi
        tolerance = np.maximum(max_cut - np.maximum(error[:-1], error[1:]), 0.0)
        return cls(points, legs, np.hypot(legs[:, 0], legs[:, 1]), headings, angles, tolerance)


@dataclass(frozen=True, eq=False)
class Corners:
    """What each corner wants, all (N,): `at_rest` where the rover must turn on the spot, `stops` where it does unless
    the corner is inside a bend, `shape` and `length` of its curve, and the `room` that this takes of both legs."""

    at_rest: Flags
    stops: Flags
    shape: corner.Shapes
    length: Array
    room: Array

    @classmethod
    def of(cls, line: Polygon, at_rest: Flags, limits: DrivingLimits, settings: BlendSettings) -> Corners:
        """As long as full speed needs and as the tolerance allows, whatever the legs have room for."""
        size = np.abs(line.angles)
        shape = limits.corner_shape(line.angles)
        at_rest = at_rest | (line.tolerance <= 0.0)
        stops = at_rest | (size > settings.max_angle)
        tangent, cut = corner.tangent_and_cut(np.where(stops, 0.0, size), shape)
        length = np.maximum(limits.corner_length(size, shape), 0.01)
        length = np.where(stops, 0.0, np.minimum(length, line.tolerance / np.maximum(cut, 1e-12)))
        # A corner that is too sharp for a curve of its own may vanish among others within the tolerance.
        room = np.where(at_rest, 0.0, np.where(stops, line.tolerance, length * tangent))
        return cls(at_rest, stops, shape, length, room)


@dataclass(frozen=True, eq=False)
class Curves:
    """Of each corner (N,): length of its curve, 0 where there is none, what that takes of both legs, its speed, and
    what clearance and sight alone allow."""

    length: Array
    taken: Array
    speed: Array
    bound: Array
    shape: corner.Shapes


def round_corners(
    line: Polygon,
    corners: Corners,
    single: Flags,
    reserved: Array,
    limits: DrivingLimits,
    settings: BlendSettings,
    clearance: ClearanceMap | None,
) -> Curves:
    """Curves around the corners that are `single`. `reserved` (N, 2): what bends take of the legs at each corner."""
    size, shape = np.abs(line.angles), corners.shape
    wanted = single & ~corners.stops
    tangent, _ = corner.tangent_and_cut(np.where(wanted, size, 0.0), shape)
    length = np.where(wanted, corners.length, 0.0)
    need = length * tangent
    lengths = line.lengths - np.append(reserved[:, 0], 0.0) - np.append(0.0, reserved[:, 1])
    # Beside a place of rest a curve leaves room to reach its speed: a curve is driven at one speed.
    at_rest = np.concatenate([[True], single & corners.stops, [True]])
    start = change_distance(0.0, limits.travel.speed, limits.travel)
    straight = np.where(at_rest[:-1] | at_rest[1:], np.minimum(start, 0.5 * lengths), 0.0)
    room = np.maximum(lengths - np.maximum(straight, settings.min_leg), 0.0)
    demand = np.append(need, 0.0) + np.append(0.0, need)
    share = np.minimum(room / np.maximum(demand, 1e-12), 1.0)
    length = length * np.minimum(share[:-1], share[1:])
    speed = limits.corner_speed(size, np.maximum(length, 1e-9), shape)
    length = length * _room_for_braking(lengths, length * tangent, speed, limits)
    speed = limits.corner_speed(size, np.maximum(length, 1e-9), shape)
    if clearance is not None:
        length, speed = _within_clearance(line, shape, length, speed, tangent, limits, settings, clearance)
    length = np.where(speed >= limits.min_speed, length, 0.0)
    taken = length * tangent
    curvature = corner.PEAK_CURVATURE[shape] * size / np.maximum(length, 1e-9)
    bound = np.minimum(limits.travel.speed, limits.sight_speed(curvature))
    if clearance is not None and limits.clearance_time > 0.0 and (length > 0.0).any():
        bound = np.minimum(bound, _clearance_at(line, taken, limits, clearance))
    return Curves(length, taken, np.minimum(speed, bound), bound, shape)


def _room_for_braking(lengths: Array, taken: Array, speed: Array, limits: DrivingLimits) -> Array:
    """Share of its length that each curve keeps, so that between it and a slower one the speed can change."""
    keep = np.ones(len(taken))
    for leg in (1 + np.flatnonzero((taken[:-1] > 0.0) & (taken[1:] > 0.0))).tolist():
        slow, fast = (leg - 1, leg) if speed[leg - 1] < speed[leg] else (leg, leg - 1)
        change = change_distance(float(speed[slow]), float(speed[fast]), limits.travel)
        missing = taken[slow] + taken[fast] + change - lengths[leg]
        if missing > 0.0:
            keep[fast] = min(keep[fast], max(1.0 - missing / taken[fast], MIN_SHARE))
    return keep


def _within_clearance(
    line: Polygon,
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
        clear = _clear(line, left, shape[left], trial, trial * tangent[left], settings.slack, clearance)
        result[left[clear]] = trial[clear]
        left = left[~clear]
    done = result > 0.0
    fastest[done] = limits.corner_speed(line.angles[done], result[done], shape[done])
    return result, fastest


def _clear(
    line: Polygon,
    number: NDArray[np.int64],
    shape: corner.Shapes,
    length: Array,
    back: Array,
    slack: float,
    clearance: ClearanceMap,
) -> Flags:
    """True for curves along which the disc touches nothing: chords, and how far the curve bulges beyond them."""
    heading, angle = line.headings[number], line.angles[number]
    at = line.points[number + 1] - back[:, None] * np.column_stack([np.cos(heading), np.sin(heading)])
    curve = corner.points(at[:, 0], at[:, 1], heading, angle, length, shape, CHORDS)
    bulge = corner.PEAK_CURVATURE[shape] * np.abs(angle) * length / (8.0 * CHORDS**2)
    a, b = curve[:, :-1].reshape(-1, 2), curve[:, 1:].reshape(-1, 2)
    swept = clearance.swept(a, b, np.repeat(bulge + slack, CHORDS))
    return np.asarray(swept.reshape(-1, CHORDS).all(axis=1), dtype=np.bool_)


def _clearance_at(line: Polygon, taken: Array, limits: DrivingLimits, clearance: ClearanceMap) -> Array:
    """Most speed at each corner by the margin there: at its ends and at the corner itself."""
    unit = line.legs / line.lengths[:, None]
    at = line.points[1:-1]
    ends = np.concatenate([at, at - unit[:-1] * taken[:, None], at + unit[1:] * taken[:, None]])
    margin = clearance.margin(ends).reshape(3, -1).min(axis=0)
    return limits.clearance_speed(margin)
