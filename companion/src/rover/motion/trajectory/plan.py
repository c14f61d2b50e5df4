"""Stretches of lines and curves to one row of quantised constant-jerk segments.

Every piece is planned from the pose and the state that the quantised segments so far really end in: its length makes
up for what is missing along the path, and the heading after a curve leads back to where the next piece should end.
Rounding does not add up, however long the path. At constant speed a curve is exactly a few constant-jerk segments;
where the speed changes, the heading is led from node to node by three.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from rover.geometry import wrap_angle
from rover.motion.merge import merge, whole_microseconds
from rover.motion.path.limits import DrivingLimits
from rover.motion.path.piece import Chain, Piece, Stretch
from rover.motion.path.speeds import PartSpeeds
from rover.motion.profile import Axis, MotionError, to_position, to_speed
from rover.motion.segment import MIN_DURATION_US, Segment, State
from rover.motion.stop import stop_segments
from rover.motion.trajectory.row import Row, curves_of
from rover.motion.trajectory.slowing import MAX_SLOWDOWNS, allowed, gentler
from rover.vehicle import Limits
from rover_native import RowMark

Array = NDArray[np.float64]

# Radians: what is nearer to the heading wanted needs no turn.
MIN_TURN_RAD = 1e-6
# A profile that passes its end by more than this many metres is none: it would come back.
MAX_OVERSHOOT_M = 1e-4
# So many curves of a bend are driven at once, before a place to come back to.
CURVES_AT_ONCE = 128
# Metres ahead at which what is missing beside the path is made up for, at least, and the most that this may turn by.
MIN_AIM_M, MAX_AIM_RAD = 0.3, 5e-3


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Segments from rest to rest, beginning at (x, y) with `heading`.

    `fields` (N, 5): of each segment, as `Segment` has them.
    `stretches`: what is driven, slower in places than was asked for. `starts`: how many segments come before each piece
    of them. `failure`: why the segments end in a controlled stop before the end of the path; empty when they do not.
    """

    fields: NDArray[np.int64]
    x: float
    y: float
    heading: float
    stretches: list[Stretch]
    starts: NDArray[np.int64]
    failure: str = ""

    @cached_property
    def segments(self) -> list[Segment]:
        """The segments one by one."""
        return Segment.rows(self.fields)

    @property
    def duration(self) -> float:
        """Seconds."""
        return float(self.fields[:, 0].sum() * 1e-6)


def plan_segments(
    stretches: Sequence[Stretch], limits: DrivingLimits, start_heading: float | None = None
) -> Trajectory:
    """Turns and drives all stretches from rest to rest. `start_heading`: None when it faces the path already.

    Where Ruckig knows no profile the segments end in a controlled stop, and `failure` says why.
    """
    if not stretches:
        none = np.zeros((0, 5), dtype=np.int64)
        return Trajectory(none, 0.0, 0.0, start_heading or 0.0, [], none[:, 0])
    x, y, heading = stretches[0].begin
    heading = heading if start_heading is None else start_heading
    row = Row(x, y, heading)
    driven: list[Stretch] = []
    starts: list[NDArray[np.int64]] = []
    failure = ""
    try:
        for stretch in stretches:
            _turn(row, stretch, limits.reserved())
            driven.append(_drive(row, stretch, limits, starts))
    except MotionError as error:
        failure = str(error)
        _stop(row, limits)
    first = np.concatenate([np.zeros(0, dtype=np.int64), *starts])
    return Trajectory(row.fields(), x, y, heading, driven, first, failure)


def _stop(row: Row, limits: DrivingLimits) -> None:
    state = State(
        speed=row.speed,
        acceleration=row.acceleration,
        turn_rate=row.turn_rate,
        turn_acceleration=row.turn_acceleration,
    )
    if not state.at_rest:
        for segment in stop_segments(state, limits.travel, limits.heading):
            row.add(segment.duration_us, segment.jerk_travel, segment.jerk_heading)
        row.rest()


def _turn(row: Row, stretch: Stretch, limits: DrivingLimits) -> None:
    """On the spot to the heading in which a stretch begins."""
    x, y, heading = stretch.begin
    length = float(np.atleast_1d(stretch.parts[0].length)[0])
    angle = wrap_angle(heading + _aim(row, (x, y), heading, length) - row.heading)
    if abs(angle) <= MIN_TURN_RAD:
        return
    for segment in merge(None, to_position(Axis(), angle, limits.heading)):
        row.add(segment.duration_us, 0, segment.jerk_heading)
    row.rest()


def _aim(row: Row, begin: tuple[float, float], heading: float, ahead: float) -> float:
    """Radians by which to turn further than a piece ends with, to be back on the path `ahead` metres after it.

    Where the rover is beside the beginning of the piece it is beside its end: what counts is across `heading` there.
    """
    beside = (row.y - begin[1]) * math.cos(heading) - (row.x - begin[0]) * math.sin(heading)
    return min(max(-beside / max(ahead, MIN_AIM_M), -MAX_AIM_RAD), MAX_AIM_RAD)


def _drive(row: Row, stretch: Stretch, limits: DrivingLimits, starts: list[NDArray[np.int64]]) -> Stretch:
    """Drives a stretch, and again from where it differs while a limit is exceeded on a part of it."""
    inside, most = limits.reserved(), allowed(limits)
    speeds = PartSpeeds(stretch.parts, inside)
    bent = any(isinstance(part, Chain) for part in stretch.parts)
    attempts = [0] * len(stretch.parts)
    marks: list[list[RowMark]] = []
    number = curve = 0
    while number < len(stretch.parts):
        del marks[number + 1 :]
        if curve == 0:
            del marks[number:]
            marks.append([])
        _part(row, speeds, number, curve, marks[number], inside)
        if number + 1 == len(stretch.parts):
            row.rest()
        number, curve = number + 1, 0
        if not bent or attempts[number - 1] == MAX_SLOWDOWNS:
            continue
        shares = row.shares(marks[number - 1][0], most)
        if shares.max(initial=0.0) > 1.0:
            part = gentler(speeds.parts[number - 1], shares, attempts[number - 1])
            attempts[number - 1] += 1
            number, curve = speeds.slower(number - 1, part)
            curve -= curve % CURVES_AT_ONCE
            row.reset(marks[number][curve // CURVES_AT_ONCE])
    for each, part in zip(marks, speeds.parts, strict=True):
        count = 1 if isinstance(part, Piece) else len(part)
        starts.append(each[0].segments + 3 * np.arange(count))
    return Stretch(tuple(speeds.parts))


def _part(row: Row, speeds: PartSpeeds, number: int, curve: int, marks: list[RowMark], limits: DrivingLimits) -> None:
    """Drives a part, a bend from one of its curves on; a mark for each CURVES_AT_ONCE of them."""
    part = speeds.parts[number]
    behind = speeds.parts[number + 1].length if number + 1 < len(speeds.parts) else 0.0
    ahead = float(behind) if isinstance(behind, float) else float(behind[0])
    del marks[curve // CURVES_AT_ONCE :]
    if isinstance(part, Piece):
        marks.append(row.mark())
        _piece(row, part, ahead, float(speeds[number][0][1]), limits)
        return
    curves = curves_of(part, speeds[number], ahead)
    for begin in range(curve, len(curves), CURVES_AT_ONCE):
        marks.append(row.mark())
        row.follow(curves[begin : begin + CURVES_AT_ONCE], limits)


def _piece(row: Row, piece: Piece, ahead: float, leave: float, limits: DrivingLimits) -> None:
    missing = (piece.x - row.x) * math.cos(piece.heading) + (piece.y - row.y) * math.sin(piece.heading)
    distance = max(piece.length + missing, 0.5 * piece.length)
    if not piece.parts:
        _line(row, distance, leave, piece.speed, limits)
        return
    end = piece.heading + piece.angle
    angle = wrap_angle(end + _aim(row, (piece.x, piece.y), end, ahead) - row.heading)
    _curve(row, distance, angle, piece)


def _line(row: Row, distance: float, leave: float, most: float, limits: DrivingLimits) -> None:
    bounds = limits.travel
    most = min(most, bounds.speed)
    if row.steady(most, leave):
        row.add(max(round(distance / row.speed * 1e6), MIN_DURATION_US), 0, 0)
        return
    for duration, jerk in _travel(row, distance, leave, Limits(most, bounds.acceleration, bounds.jerk)):
        row.add(duration, jerk, 0)


def _travel(row: Row, distance: float, leave: float, bounds: Limits) -> list[tuple[int, int]]:
    """(µs, µm/s³) over a distance to the speed at its end. Raises MotionError.

    Where rounding has left too little way for the change of speed, the change counts: the next piece is shorter then.
    """
    start = Axis(0.0, row.speed, row.acceleration)
    profile = to_position(start, distance, bounds, leave)
    if profile.highest > distance + MAX_OVERSHOOT_M or profile.lowest < -MAX_OVERSHOOT_M:
        profile = to_speed(start, leave, bounds)
    return whole_microseconds(profile)


def _curve(row: Row, distance: float, angle: float, piece: Piece) -> None:
    """The curve of a corner at constant speed. Turn rate and acceleration are exactly zero again at the end."""
    if row.speed <= 0.0:
        raise MotionError("no motion profile: the rover stands where a curve begins")
    duration = distance / row.speed * 1e6
    level = piece.parts[2][0] / piece.length if len(piece.parts) == 5 else 0.0
    level_us = round(level * duration)
    level_us = level_us if level_us >= MIN_DURATION_US else 0
    side_us = max(round((duration - level_us) / 4.0), MIN_DURATION_US)
    turn = (side_us * 1e-6) ** 2 * (2 * side_us + level_us) * 1e-6  # radians for each rad/s³ of jerk
    row.bend(side_us, level_us, round(angle / turn * 1e6))
