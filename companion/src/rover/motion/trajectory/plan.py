"""Stretches of lines and curves to one row of quantised constant-jerk segments.

Every line is planned from the state that the quantised segments so far end in, and every curve turns by what is missing
to the heading after it: rounding does not add up. Curves are driven at constant speed, where corner.py makes their
heading exactly a few constant-jerk segments.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from rover.geometry import wrap_angle
from rover.motion.merge import merge, whole_microseconds
from rover.motion.path import corner
from rover.motion.path.blend import Piece, Stretch
from rover.motion.path.limits import DrivingLimits
from rover.motion.path.speeds import node_speeds
from rover.motion.profile import Axis, MotionError, to_position
from rover.motion.segment import MAX_DURATION_US, MIN_DURATION_US, Segment, State, after
from rover.motion.stop import stop_segments
from rover.vehicle import Limits

# Radians: what is nearer to the heading wanted needs no turn.
MIN_TURN_RAD = 1e-6
# Metres per second: nearer speeds are the same.
MIN_SPEED_CHANGE_M_S = 2e-5
# A profile that passes its end by more than this many metres is none: it would come back.
MAX_OVERSHOOT_M = 1e-4


@dataclass(frozen=True)
class Trajectory:
    """Segments from rest to rest, beginning at (x, y) with `heading`.

    `starts`: how many segments come before each piece of the stretches. `failure`: why the segments end in a controlled
    stop before the end of the path; empty when they do not.
    """

    segments: list[Segment]
    x: float
    y: float
    heading: float
    starts: list[int]
    failure: str = ""

    @property
    def duration(self) -> float:
        """Seconds."""
        return sum(segment.duration_us for segment in self.segments) * 1e-6


class _Row:
    """Segments so far as plain numbers, and the exact state at their end."""

    def __init__(self, heading: float) -> None:
        self.numbers: list[tuple[int, int, int, bool, bool]] = []
        self.travel = self.speed = self.acceleration = 0.0
        self.heading = heading
        self._begin = True

    def add(self, duration_us: int, jerk_travel: int, jerk_heading: int) -> None:
        while duration_us > MAX_DURATION_US:
            self.add(MAX_DURATION_US // 2, jerk_travel, jerk_heading)
            duration_us -= MAX_DURATION_US // 2
        t, j = duration_us * 1e-6, jerk_travel * 1e-6
        self.travel += t * (self.speed + t * (self.acceleration / 2.0 + t * j / 6.0))
        self.speed += t * (self.acceleration + t * j / 2.0)
        self.acceleration += t * j
        self.numbers.append((duration_us, jerk_travel, jerk_heading, self._begin, False))
        self._begin = False

    def bend(self, side_us: int, level_us: int, jerk_heading: int) -> None:
        """The parts of a curve, without jerk of travel; never the beginning of a run."""
        t = (4 * side_us + level_us) * 1e-6
        self.travel += t * (self.speed + t * self.acceleration / 2.0)
        self.speed += t * self.acceleration
        up, down = (side_us, 0, jerk_heading, False, False), (side_us, 0, -jerk_heading, False, False)
        if level_us:
            self.numbers += (up, down, (level_us, 0, 0, False, False), down, up)
        else:
            self.numbers += (up, (2 * side_us, 0, -jerk_heading, False, False), up)

    def rest(self) -> None:
        """What was added last ends at rest; what comes next begins a run."""
        if not self._begin:
            self.numbers[-1] = (*self.numbers[-1][:4], True)
            self.speed = self.acceleration = 0.0
            self._begin = True


def plan_segments(
    stretches: Sequence[Stretch], limits: DrivingLimits, start_heading: float | None = None
) -> Trajectory:
    """Turns and drives all stretches from rest to rest. `start_heading`: None when it faces the path already.

    Where Ruckig knows no profile the segments end in a controlled stop, and `failure` says why.
    """
    if not stretches:
        return Trajectory([], 0.0, 0.0, start_heading or 0.0, [])
    first = stretches[0].pieces[0]
    heading = first.heading if start_heading is None else start_heading
    row = _Row(heading)
    starts: list[int] = []
    failure = ""
    inside = limits.reserved()
    try:
        for stretch in stretches:
            _turn(row, stretch.pieces[0], inside)
            _drive(row, stretch, inside, starts)
    except MotionError as error:
        failure = str(error)
        _stop(row, limits)
    return Trajectory(Segment.rows(row.numbers), first.x, first.y, heading, starts, failure)


def _stop(row: _Row, limits: DrivingLimits) -> None:
    state = State(speed=row.speed, acceleration=row.acceleration)
    if not state.at_rest:
        for segment in stop_segments(state, limits.travel, limits.heading):
            row.add(segment.duration_us, segment.jerk_travel, segment.jerk_heading)
        row.rest()


def _turn(row: _Row, piece: Piece, limits: DrivingLimits) -> None:
    """On the spot to the heading of a piece."""
    angle = wrap_angle(piece.heading - row.heading)
    if abs(angle) <= MIN_TURN_RAD:
        return
    state = State()
    for segment in merge(None, to_position(Axis(), angle, limits.heading)):
        row.add(segment.duration_us, 0, segment.jerk_heading)
        state = after(state, segment)
    row.heading += state.heading
    row.rest()


def _drive(row: _Row, stretch: Stretch, limits: DrivingLimits, starts: list[int]) -> None:
    speeds = node_speeds(stretch.pieces, limits.travel)
    # Way that is due at the end of each piece: what rounding left over, the next line makes up for.
    due = row.travel
    for piece, leave in zip(stretch.pieces, speeds[1:], strict=True):
        starts.append(len(row.numbers))
        due += piece.length
        if piece.angle == 0.0:
            _line(row, due - row.travel, leave, piece.speed, limits)
        else:
            angle = wrap_angle(piece.heading + piece.angle - row.heading)
            _curve(row, due - row.travel, angle, corner.LEVELS[piece.shape])
    row.rest()


def _line(row: _Row, distance: float, leave: float, most: float, limits: DrivingLimits) -> None:
    bounds = limits.travel
    most = min(most, bounds.speed)
    if (
        abs(row.speed - most) < MIN_SPEED_CHANGE_M_S
        and abs(leave - most) < MIN_SPEED_CHANGE_M_S
        and abs(row.acceleration) < MIN_SPEED_CHANGE_M_S
    ):
        row.add(max(round(distance / row.speed * 1e6), MIN_DURATION_US), 0, 0)
        return
    start = Axis(0.0, row.speed, row.acceleration)
    profile = to_position(start, distance, Limits(most, bounds.acceleration, bounds.jerk), leave)
    if profile.highest > distance + MAX_OVERSHOOT_M or profile.lowest < -MAX_OVERSHOOT_M:
        raise MotionError("no motion profile: the line is too short for the change of speed")
    for duration, jerk in whole_microseconds(profile):
        row.add(duration, jerk, 0)


def _curve(row: _Row, distance: float, angle: float, level: float) -> None:
    """The parts of a curve at constant speed, the level one of the share `level`.

    Turn rate and acceleration are exactly zero again at the end.
    """
    if row.speed <= 0.0:
        raise MotionError("no motion profile: the rover stands where a curve begins")
    duration = distance / row.speed * 1e6
    level_us = round(level * duration)
    level_us = level_us if level_us >= MIN_DURATION_US else 0
    side_us = max(round((duration - level_us) / 4.0), MIN_DURATION_US)
    turn = (side_us * 1e-6) ** 2 * (2 * side_us + level_us) * 1e-6  # radians for each rad/s³ of jerk
    jerk = round(angle / turn * 1e6)
    row.bend(side_us, level_us, jerk)
    row.heading += jerk * 1e-6 * turn
