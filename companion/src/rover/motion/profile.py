"""Time-optimal jerk-limited profiles of one axis, by Ruckig with one degree of freedom and no waypoints.

(Waypoints would make Ruckig call a web service; nothing here can reach a network.)
"""

from __future__ import annotations

from dataclasses import dataclass

import ruckig

from rover.errors import RoverError
from rover.vehicle import Limits


class MotionError(RoverError):
    """No profile exists for what was asked; the caller makes a controlled stop of it."""


@dataclass(frozen=True)
class Axis:
    """Position, speed and acceleration of one axis (SI)."""

    position: float = 0.0
    speed: float = 0.0
    acceleration: float = 0.0


@dataclass(frozen=True)
class Profile:
    """Pieces of constant jerk (duration in s, jerk) and the lowest and highest position on the way."""

    pieces: tuple[tuple[float, float], ...]
    lowest: float
    highest: float

    @property
    def duration(self) -> float:
        """Seconds."""
        return sum(duration for duration, _ in self.pieces)


def to_position(start: Axis, target: float, limits: Limits, end_speed: float = 0.0) -> Profile:
    """From `start` to `target` with `end_speed` and no acceleration there. Raises MotionError."""
    request = _request(start, limits)
    request.control_interface = ruckig.ControlInterface.Position
    request.target_position = [target]
    request.target_velocity = [end_speed]
    request.target_acceleration = [0.0]
    return _solve(request)


def to_speed(start: Axis, speed: float, limits: Limits) -> Profile:
    """From `start` to a constant `speed`, wherever that is. Raises MotionError."""
    request = _request(start, limits)
    request.control_interface = ruckig.ControlInterface.Velocity
    request.target_velocity = [speed]
    request.target_acceleration = [0.0]
    return _solve(request)


def speed_after(profile: Profile, start: Axis, time: float) -> float:
    """Speed `time` seconds into a profile that begins at `start`."""
    v, a = start.speed, start.acceleration
    for duration, jerk in profile.pieces:
        t = min(duration, time)
        v += t * (a + t * jerk / 2.0)
        a += t * jerk
        time -= t
        if time <= 0.0:
            break
    return v


def _request(start: Axis, limits: Limits) -> ruckig.InputParameter:
    request = ruckig.InputParameter(1)
    request.current_position = [start.position]
    request.current_velocity = [start.speed]
    request.current_acceleration = [start.acceleration]
    request.max_velocity = [limits.speed]
    request.max_acceleration = [limits.acceleration]
    request.max_jerk = [limits.jerk]
    return request


def _solve(request: ruckig.InputParameter) -> Profile:
    trajectory = ruckig.Trajectory(1)
    try:
        result = ruckig.Ruckig(1).calculate(request, trajectory)
    except ruckig.RuckigError as error:
        raise MotionError(f"no motion profile: {' '.join(str(error).split())}") from error
    if int(result) < 0:
        raise MotionError(f"no motion profile: Ruckig answered {result.name}")
    profile = trajectory.profiles[0][0]
    pieces = (
        *zip(profile.brake.t, profile.brake.j, strict=True),
        *zip(profile.t, profile.j, strict=True),
        *zip(profile.accel.t, profile.accel.j, strict=True),
    )
    extrema = trajectory.position_extrema[0]
    return Profile(tuple((t, j) for t, j in pieces if t > 0.0), extrema.min, extrema.max)
