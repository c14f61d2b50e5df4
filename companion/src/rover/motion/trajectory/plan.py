"""Stretches of lines and curves to one row of quantised constant-jerk segments.

Every piece is planned from the pose and the state that the quantised segments so far really end in: its length makes
up for what is missing along the path, and the heading after a curve leads back to where the next piece should end.
Rounding does not add up, however long the path. At constant speed a curve is exactly a few constant-jerk segments;
where the speed changes, the heading is led from node to node by three.
"""

from __future__ import annotations

import bisect
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from rover.geometry import wrap_angle
from rover.motion.merge import merge, whole_microseconds
from rover.motion.path.limits import DrivingLimits
from rover.motion.path.piece import Piece, Stretch
from rover.motion.path.speeds import smooth_speeds
from rover.motion.profile import Axis, MotionError, to_position, to_speed
from rover.motion.segment import MIN_DURATION_US, Segment, State
from rover.motion.stop import stop_segments
from rover.motion.trajectory.row import Mark, Row, jerks_to
from rover.motion.trajectory.slowing import MAX_SLOWDOWNS, exceeding, slower
from rover.vehicle import Limits

# Radians: what is nearer to the heading wanted needs no turn.
MIN_TURN_RAD = 1e-6
# A profile that passes its end by more than this many metres is none: it would come back.
MAX_OVERSHOOT_M = 1e-4
# Metres ahead at which what is missing beside the path is made up for, at least, and the most that this may turn by.
MIN_AIM_M, MAX_AIM_RAD = 0.3, 5e-3


@dataclass(frozen=True)
class Trajectory:
    """Segments from rest to rest, beginning at (x, y) with `heading`.

    `stretches`: what is driven, slower in places than was asked for. `starts`: how many segments come before each piece
    of them. `failure`: why the segments end in a controlled stop before the end of the path; empty when they do not.
    """

    segments: list[Segment]
    x: float
    y: float
    heading: float
    stretches: list[Stretch]
    starts: list[int]
    failure: str = ""

    @property
    def duration(self) -> float:
        """Seconds."""
        return sum(segment.duration_us for segment in self.segments) * 1e-6


def plan_segments(
    stretches: Sequence[Stretch], limits: DrivingLimits, start_heading: float | None = None
) -> Trajectory:
    """Turns and drives all stretches from rest to rest. `start_heading`: None when it faces the path already.

    Where Ruckig knows no profile the segments end in a controlled stop, and `failure` says why.
    """
    if not stretches:
        return Trajectory([], 0.0, 0.0, start_heading or 0.0, [], [])
    first = stretches[0].pieces[0]
    heading = first.heading if start_heading is None else start_heading
    row = Row(first.x, first.y, heading)
    driven: list[Stretch] = []
    starts: list[int] = []
    failure = ""
    try:
        for stretch in stretches:
            _turn(row, stretch.pieces[0], limits.reserved())
            driven.append(_drive(row, stretch, limits, starts))
    except MotionError as error:
        failure = str(error)
        _stop(row, limits)
    return Trajectory(Segment.rows(row.numbers), first.x, first.y, heading, driven, starts, failure)


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


def _turn(row: Row, piece: Piece, limits: DrivingLimits) -> None:
    """On the spot to the heading of a piece."""
    aim = _aim(row, replace(piece, angle=0.0), piece.length)
    angle = wrap_angle(piece.heading + aim - row.heading)
    if abs(angle) <= MIN_TURN_RAD:
        return
    for segment in merge(None, to_position(Axis(), angle, limits.heading)):
        row.add(segment.duration_us, 0, segment.jerk_heading)
    row.rest()


def _aim(row: Row, piece: Piece, ahead: float) -> float:
    """Radians by which to turn further than a piece ends with, to be back on the path `ahead` metres after it.

    Where the rover is beside the beginning of the piece it is beside its end: what counts is across the heading there.
    """
    heading = piece.heading + piece.angle
    beside = (row.y - piece.y) * math.cos(heading) - (row.x - piece.x) * math.sin(heading)
    return min(max(-beside / max(ahead, MIN_AIM_M), -MAX_AIM_RAD), MAX_AIM_RAD)


def _drive(row: Row, stretch: Stretch, limits: DrivingLimits, starts: list[int]) -> Stretch:
    """Drives a stretch, and again from where it differs while a limit is exceeded anywhere along a bend."""
    inside, begin = limits.reserved(), len(row.numbers)
    marks: list[Mark] = []
    speeds, accelerations = smooth_speeds(stretch.pieces, inside.travel)
    first = 0
    for _ in range(MAX_SLOWDOWNS):
        for number in range(first, len(stretch.pieces)):
            marks.append(row.mark())
            _piece(row, stretch.pieces, number, (speeds[number + 1], accelerations[number + 1]), inside)
        row.rest()
        if all(piece.change is None for piece in stretch.pieces):
            break
        over = exceeding(row.numbers[begin:], limits)
        counts = [mark.segments - begin for mark in marks]
        pieces = {bisect.bisect_right(counts, number) - 1 for number in over}
        if not pieces:
            break
        stretch, before = slower(stretch, pieces), (stretch.pieces, speeds, accelerations)
        speeds, accelerations = smooth_speeds(stretch.pieces, inside.travel)
        first = next(
            number
            for number in range(len(stretch.pieces))
            if stretch.pieces[number] is not before[0][number]
            or (speeds[number + 1], accelerations[number + 1]) != (before[1][number + 1], before[2][number + 1])
        )
        row.reset(marks[first])
        del marks[first:]
    starts += [mark.segments for mark in marks]
    return stretch


def _piece(row: Row, pieces: Sequence[Piece], number: int, end: tuple[float, float], limits: DrivingLimits) -> None:
    piece = pieces[number]
    missing = (piece.x - row.x) * math.cos(piece.heading) + (piece.y - row.y) * math.sin(piece.heading)
    distance = max(piece.length + missing, 0.5 * piece.length)
    if not piece.parts:
        _line(row, distance, end[0], piece.speed, limits)
        return
    ahead = pieces[number + 1].length if number + 1 < len(pieces) else 0.0
    angle = wrap_angle(piece.heading + piece.angle + _aim(row, piece, ahead) - row.heading)
    if piece.change is None:
        _curve(row, distance, angle, piece)
    else:
        _bend(row, distance, angle, piece, end, limits)


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


def _bend(
    row: Row, distance: float, angle: float, piece: Piece, end: tuple[float, float], limits: DrivingLimits
) -> None:
    """A piece of a bend, in three equal times: from the state now to speed and acceleration (`end`), curvature and its
    slope at the end."""
    speed, acceleration = end
    _, curvature, rate = piece.turning(piece.length)
    third = max(round(_duration(row, distance, end) * 1e6 / 3.0), MIN_DURATION_US)
    time = 3e-6 * third
    way = time * (row.speed + speed) / 2.0 + time**2 * (row.acceleration - acceleration) / 12.0
    travel = jerks_to((row.speed, row.acceleration), end, (way, distance), third, limits.travel.jerk)
    turning = jerks_to(
        (row.turn_rate, row.turn_acceleration),
        (curvature * speed, rate * speed**2 + curvature * acceleration),
        (piece.angle, angle),
        third,
        limits.heading.jerk,
    )
    for jerk, turn_jerk in zip(travel, turning, strict=True):
        row.add(third, jerk, turn_jerk)


def _duration(row: Row, distance: float, end: tuple[float, float]) -> float:
    """Seconds in which a quintic would lead over the distance: T (v₀ + v₁) / 2 + T² (a₀ − a₁) / 12."""
    speeds, change = row.speed + end[0], (row.acceleration - end[1]) / 12.0
    time = 2.0 * distance / max(speeds, 1e-6)
    for _ in range(3):
        time = distance / max(speeds / 2.0 + time * change, 0.2 * speeds, 1e-6)
    return time
