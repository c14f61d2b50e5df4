"""One stretch of lines and curves as the follower drives it: arc length, nominal turning, and speeds of its pieces."""

from __future__ import annotations

import bisect
import itertools
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from rover.motion.path.piece import Piece, Stretch
from rover.motion.path.polyline import Point, Polyline
from rover.motion.path.speeds import node_speeds
from rover.motion.profile import Axis, MotionError, Profile, to_position, to_speed
from rover.vehicle import Limits

# Points on a curve; chords this short differ from the arc by less than a tenth of a millimetre in length.
CURVE_POINTS = 20
# Of the travel limits, what the speeds at the joints of pieces are planned with: the rest is for what differs.
PLANNED_SHARE = 0.8
# Metres by which a profile may pass the joint that it was planned to.
MAX_OVERSHOOT_M = 0.002
SPEED_TOLERANCE_M_S = 1e-3


class Curve(Polyline):
    """The polyline of a stretch, its corners already round, and what is to be driven along it."""

    def __init__(self, stretch: Stretch, limits: Limits) -> None:
        points: list[Point] = []
        joints = [0]
        for piece in stretch.pieces:
            points.append((piece.x, piece.y))
            if piece.parts:
                points += _points(piece, CURVE_POINTS)[1:-1]
            joints.append(len(points))
        last = stretch.pieces[-1]
        points.append(_points(last, CURVE_POINTS if last.parts else 1)[-1])
        super().__init__(points)
        self.pieces = stretch.pieces
        # Arc length of the chords at which each piece begins, and the end.
        self.joints = [self._starts[index] for index in joints]
        careful = Limits(limits.speed, PLANNED_SHARE * limits.acceleration, PLANNED_SHARE * limits.jerk)
        self.speeds = node_speeds(stretch.pieces, careful)
        self._turned: list[float] = [0.0, *np.cumsum([piece.angle for piece in stretch.pieces]).tolist()]

    def piece_at(self, s: float) -> int:
        """Number of the piece at arc length `s`."""
        return min(max(bisect.bisect_right(self.joints, s) - 1, 0), len(self.pieces) - 1)

    def _along(self, number: int, s: float) -> float:
        """Arc length along a piece at `s`."""
        begin, end = self.joints[number], self.joints[number + 1]
        return self.pieces[number].length * min(max((s - begin) / (end - begin), 0.0), 1.0)

    def turned(self, s: float) -> float:
        """Radians that the curves before `s` have turned by; corners that are driven through do not count."""
        number = self.piece_at(s)
        return self._turned[number] + self.pieces[number].turning(self._along(number, s))[0]

    def turning(self, s: float) -> tuple[float, float]:
        """Curvature (1/m) and its slope (1/m²) at `s`."""
        number = self.piece_at(s)
        _, curvature, rate = self.pieces[number].turning(self._along(number, s))
        return curvature, rate

    def curved_within(self, begin: float, end: float) -> bool:
        """True when some of the way between two arc lengths is curved."""
        return any(bool(piece.parts) for piece in self.pieces[self.piece_at(begin) : self.piece_at(end) + 1])

    def heading_profile(self, s: float, speed: float, duration: float) -> tuple[tuple[float, float], ...]:
        """The nominal turning as pieces of constant jerk, from `s` on at a constant speed over the ground."""
        if speed < 1e-4:
            return ()
        found: list[tuple[float, float]] = []
        left = duration
        while left > 1e-6 and s < self.joints[-1]:
            number = self.piece_at(s)
            piece = self.pieces[number]
            begin, end = self.joints[number], self.joints[number + 1]
            jerk = 0.0
            if piece.parts:
                third, until = piece.part_at(self._along(number, s) + 1e-9)
                end = begin + (end - begin) * until / piece.length
                jerk = third * speed**3
            time = min(max((end - s) / speed, 1e-6), left)
            found.append((time, jerk))
            left -= time
            s = max(end, s + 1e-9)
        return tuple(found)

    def travel_profile(
        self, s: float, state: Axis, rest: float, limits: Limits, scale: float, until: float
    ) -> tuple[Profile, bool]:
        """Travel from `s` for at least `until` seconds or to rest, and whether it comes to rest at the end.

        `state`: commanded speed and acceleration; `rest`: commanded metres to the end of the stretch; `scale`: metres
        of ground for each commanded one. Raises MotionError.
        """
        found: list[tuple[float, float]] = []
        axis = Axis(0.0, state.speed, state.acceleration)
        way = time = 0.0
        for _ in range(4 * len(self.pieces) + 4):
            at = s + way * scale
            number = self.piece_at(at)
            piece = self.pieces[number]
            if number == len(self.pieces) - 1:
                bounds = Limits(min(limits.speed, piece.speed), limits.acceleration, limits.jerk)
                profile = to_position(axis, max(rest - way, 0.0), bounds)
                if profile.highest > rest - way + MAX_OVERSHOOT_M:  # it would pass the end and come back
                    profile = to_speed(axis, 0.0, limits)
                return Profile((*found, *profile.pieces), 0.0, rest), True
            left = (self.joints[number + 1] - at) / scale
            leave = self.speeds[number + 1]
            pieces, axis, made = _to_joint(piece, axis, left, leave, limits)
            found += pieces
            way += max(made, 1e-6)
            time += sum(duration for duration, _ in pieces)
            if time >= until:
                return Profile(tuple(found), 0.0, way), False
        raise MotionError("no motion profile: the pieces of the path do not lead on")


def _to_joint(
    piece: Piece, axis: Axis, left: float, leave: float, limits: Limits
) -> tuple[tuple[tuple[float, float], ...], Axis, float]:
    """Pieces to the end of a piece, the state there, and the way made (commanded metres)."""
    if piece.parts:
        if abs(axis.speed - leave) < SPEED_TOLERANCE_M_S and abs(axis.acceleration) < 10.0 * SPEED_TOLERANCE_M_S:
            return ((left / leave, 0.0),), Axis(0.0, leave, 0.0), left + 1e-6
        change = piece.change or limits
        profile = to_speed(axis, leave, replace(limits, acceleration=change.acceleration, jerk=change.jerk))
    else:
        bounds = Limits(min(limits.speed, piece.speed), limits.acceleration, limits.jerk)
        profile = to_position(axis, left, bounds, leave)
        if profile.highest > left + MAX_OVERSHOOT_M or profile.lowest < -MAX_OVERSHOOT_M:
            profile = to_speed(axis, leave, limits)
        else:
            return profile.pieces, Axis(0.0, leave, 0.0), left + 1e-6
    x, v, a = 0.0, axis.speed, axis.acceleration
    for t, jerk in profile.pieces:
        x += t * (v + t * (a / 2.0 + t * jerk / 6.0))
        v += t * (a + t * jerk / 2.0)
        a += t * jerk
    return profile.pieces, Axis(0.0, leave, 0.0), x


def _points(piece: Piece, count: int) -> list[Point]:
    return [(float(x), float(y)) for x, y in piece.points(count)]


def together(a: Sequence[tuple[float, float]], b: Sequence[tuple[float, float]]) -> tuple[tuple[float, float], ...]:
    """Two rows of (duration, jerk) that run at the same time as one; the shorter goes on without jerk."""
    times = sorted({0.0, *np.cumsum([t for t, _ in a]).tolist(), *np.cumsum([t for t, _ in b]).tolist()})
    found = []
    for begin, end in itertools.pairwise(times):
        middle = 0.5 * (begin + end)
        found.append((end - begin, _jerk_at(a, middle) + _jerk_at(b, middle)))
    return tuple((t, jerk) for t, jerk in found if t > 0.0)


def _jerk_at(pieces: Sequence[tuple[float, float]], time: float) -> float:
    for duration, jerk in pieces:
        if time < duration:
            return jerk
        time -= duration
    return 0.0
