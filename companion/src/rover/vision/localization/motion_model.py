"""How the rover moves between frames, and how wrong that may be: by its wheels, or freely without any.

Both move the robot's part of the filter's state (`pose_filter`): x, y, heading and two numbers of motion. What
follows there about the camera stays as it is.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rover.geometry import Pose2, wrap_angle
from rover.vision.localization.motion_history import Travel

Array = NDArray[np.float64]

ROBOT = 8
# Where the three numbers of how the camera sits begin.
OFFSET = 5


@dataclass(frozen=True)
class MotionNoise:
    """How wheels err; standard deviations.

    slip_start: of each wheel's slip before anything is known. slip_walk: its change over one metre of travel.
    travel: of a wheel's travel over one metre, m. sideways: of the sideways shift over one radian turned, m.
    uncovered_*: speed (m/s) and turn (rad/s) while no wheel report covers the time.
    """

    slip_start: float = 0.02
    slip_walk: float = 0.010
    travel: float = 0.006
    sideways: float = 0.003
    uncovered_speed: float = 0.25
    uncovered_turn: float = 1.2


def advance(
    robot: Array, left_m: float, right_m: float, track: float, noise: MotionNoise
) -> tuple[Array, Array, Array]:
    """One wheel report: the new robot state (8,), its Jacobian (8, 8) and the added noise (8, 8).

    left_m, right_m: travel as the wheels report it; what is real is 1 - slip of it. Midpoint integration.
    """
    x, y, heading, slip_left, slip_right, *offset = robot.tolist()
    left, right = left_m * (1.0 - slip_left), right_m * (1.0 - slip_right)
    ahead, turn = 0.5 * (left + right), (right - left) / track
    middle = heading + 0.5 * turn
    c, s = math.cos(middle), math.sin(middle)
    new = np.array([x + ahead * c, y + ahead * s, heading + turn, slip_left, slip_right, *offset])
    # Columns: how a metre of the left and of the right wheel moves (x, y, heading).
    by_left = (0.5 * c + 0.5 * ahead * s / track, 0.5 * s - 0.5 * ahead * c / track, -1.0 / track)
    by_right = (0.5 * c - 0.5 * ahead * s / track, 0.5 * s + 0.5 * ahead * c / track, 1.0 / track)
    jacobian = np.eye(ROBOT)
    jacobian[0, 2], jacobian[1, 2] = -ahead * s, ahead * c
    jacobian[:3, 3] = [-left_m * g for g in by_left]
    jacobian[:3, 4] = [-right_m * g for g in by_right]
    steer = np.array([by_left, by_right, (-s, c, 0.0)]).T
    variances = (
        noise.travel**2 * abs(left_m),
        noise.travel**2 * abs(right_m),
        noise.sideways**2 * abs(turn),
    )
    added = np.zeros((ROBOT, ROBOT))
    added[:3, :3] = (steer * variances) @ steer.T
    added[3, 3] = noise.slip_walk**2 * abs(left_m)
    added[4, 4] = noise.slip_walk**2 * abs(right_m)
    return new, jacobian, added


def rolled(pose: Pose2, left_m: float, right_m: float, track: float) -> Pose2:
    """Where wheels that do not slip bring the rover."""
    ahead, turn = 0.5 * (left_m + right_m), (right_m - left_m) / track
    middle = pose.heading + 0.5 * turn
    x, y = pose.x + ahead * math.cos(middle), pose.y + ahead * math.sin(middle)
    return Pose2(x, y, wrap_angle(pose.heading + turn))


@dataclass(frozen=True)
class GyroNoise:
    """How a gyroscope errs whose bias is taken off; standard deviations.

    scale: share of a turn. walk: rad over the root of a second. burst: metres by which the wheels of one report may
    turn otherwise than the gyroscope before one of them counts as slipping; slipped: share of what that wheel then
    seems to have lost that may be wrong.
    """

    scale: float = 0.006
    walk: float = 0.001
    burst: float = 0.0006
    slipped: float = 0.3


def advance_turned(
    robot: Array, travel: Travel, turn: float, track: float, noise: MotionNoise, gyro: GyroNoise
) -> tuple[Array, Array, Array]:
    """As `advance`, where a gyroscope has measured the turn: the wheels tell the way alone.

    Wheels that turn otherwise than the gyroscope slip. A wheel that slips has rolled too far, hardly ever too little:
    the whole difference is taken from the one that has.
    """
    x, y, heading, slip_left, slip_right, *offset = robot.tolist()
    left, right = travel.left * (1.0 - slip_left), travel.right * (1.0 - slip_right)
    excess = (right - left) - turn * track
    lost = abs(excess) if abs(excess) > gyro.burst else 0.0
    if lost:
        left, right = _gripping(left, right, excess)
    ahead = 0.5 * (left + right)
    middle = heading + 0.5 * turn
    c, s = math.cos(middle), math.sin(middle)
    new = np.array([x + ahead * c, y + ahead * s, heading + turn, slip_left, slip_right, *offset])
    jacobian = np.eye(ROBOT)
    jacobian[0, 2], jacobian[1, 2] = -ahead * s, ahead * c
    jacobian[:2, 3] = (-0.5 * travel.left * c, -0.5 * travel.left * s)
    jacobian[:2, 4] = (-0.5 * travel.right * c, -0.5 * travel.right * s)
    steer = np.array([(c, s, 0.0), (-s, c, 0.0), (-0.5 * ahead * s, 0.5 * ahead * c, 1.0)]).T
    variances = (
        0.25 * noise.travel**2 * (abs(travel.left) + abs(travel.right)) + (0.5 * gyro.slipped * lost) ** 2,
        noise.sideways**2 * abs(turn),
        (gyro.scale * turn) ** 2 + gyro.walk**2 * max(travel.end - travel.begin, 0.0),
    )
    added = np.zeros((ROBOT, ROBOT))
    added[:3, :3] = (steer * variances) @ steer.T
    added[3, 3] = noise.slip_walk**2 * abs(travel.left)
    added[4, 4] = noise.slip_walk**2 * abs(travel.right)
    return new, jacobian, added


def _gripping(left: float, right: float, excess: float) -> tuple[float, float]:
    """Ways of the wheels without what one of them has rolled too far; of both, where it may be either."""
    of_right, of_left = excess * right > 0.0, excess * left < 0.0
    if of_right and of_left:
        return left + 0.5 * excess, right - 0.5 * excess
    return left + excess * of_left, right - excess * of_right


@dataclass(frozen=True)
class FreeMotionNoise:
    """How a rover moves of which nothing is measured: speed and turn rate stay, but for; standard deviations.

    speed, turn: m/s and rad/s when nothing is known. acceleration, turn_acceleration: m/s² and rad/s², kept for one
    frame's time. sideways: m/s, new with each frame. fade: seconds in which a speed that is not seen is forgotten.
    """

    speed: float = 0.15
    turn: float = 0.8
    acceleration: float = 0.5
    turn_acceleration: float = 3.0
    sideways: float = 0.02
    fade: float = 2.0


def advance_freely(robot: Array, elapsed: float, noise: FreeMotionNoise) -> tuple[Array, Array, Array]:
    """`elapsed` seconds at steady speed and turn rate: new state (8,), Jacobian (8, 8), added noise (8, 8)."""
    x, y, heading, speed, rate, *offset = robot.tolist()
    ahead, turn = speed * elapsed, rate * elapsed
    middle = heading + 0.5 * turn
    c, s = math.cos(middle), math.sin(middle)
    left = math.exp(-elapsed / noise.fade)
    new = np.array([x + ahead * c, y + ahead * s, heading + turn, left * speed, left * rate, *offset])
    jacobian = np.eye(ROBOT)
    jacobian[0, 2], jacobian[1, 2] = -ahead * s, ahead * c
    jacobian[:2, 3] = elapsed * c, elapsed * s
    jacobian[:3, 4] = -0.5 * elapsed * ahead * s, 0.5 * elapsed * ahead * c, elapsed
    jacobian[3, 3] = jacobian[4, 4] = left
    half = 0.5 * elapsed * elapsed
    by_acceleration = np.array([half * c, half * s, 0.0, elapsed, 0.0, 0.0, 0.0, 0.0]) * noise.acceleration
    by_turning = np.array([0.0, 0.0, half, 0.0, elapsed, 0.0, 0.0, 0.0]) * noise.turn_acceleration
    by_sliding = np.array([-s, c, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]) * (noise.sideways * elapsed)
    steer = np.array([by_acceleration, by_turning, by_sliding]).T
    return new, jacobian, steer @ steer.T
