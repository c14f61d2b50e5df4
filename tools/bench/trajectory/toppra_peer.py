"""What toppra (https://github.com/hungpham2511/toppra) needs for the same lines and curves.

It gets every limit but those of jerk, which it does not know: speed, acceleration, turn rate, turn acceleration,
lateral acceleration, clearance and sight. Turns on the spot cost it the fastest turn of limited speed and
acceleration.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from rover.geometry import wrap_angle
from rover.motion.path.limits import DrivingLimits
from rover.motion.path.piece import Piece, Stretch

Array = NDArray[np.float64]

# Metres between toppra's grid points, on lines and on curves; at least so many on each curve.
LINE_STEP_M, CURVE_STEP_M, MIN_POINTS = 0.02, 0.01, 6


def toppra_times(stretches: Sequence[Stretch], limits: DrivingLimits) -> tuple[float, float]:
    """Seconds that toppra needs for driving, and the fastest turns on the spot between the stretches."""
    driving = sum(_driving(*_along(stretch.pieces, limits), limits) for stretch in stretches)
    turning = 0.0
    for before, behind in pairwise(stretches):
        last = before.pieces[-1]
        angle = abs(wrap_angle(behind.pieces[0].heading - last.heading - last.angle))
        speed, acceleration = limits.heading.speed, limits.heading.acceleration
        flat = max(angle - speed * speed / acceleration, 0.0)
        turning += flat / speed + 2.0 * math.sqrt((angle - flat) / acceleration)
    return driving, turning


def shape_time(shape: Array, limits: DrivingLimits) -> float:
    """Seconds that toppra needs along a smooth shape itself, finely sampled (N, 2)."""
    steps = np.diff(shape, axis=0)
    way = np.concatenate([[0.0], np.cumsum(np.hypot(steps[:, 0], steps[:, 1]))])
    heading = np.unwrap(np.arctan2(np.gradient(shape[:, 1], way), np.gradient(shape[:, 0], way)))
    grid = np.linspace(0.0, way[-1], max(200, math.ceil(way[-1] / CURVE_STEP_M)))
    curvature = np.gradient(heading, way)
    slope = np.interp(grid, way, curvature)
    second = np.interp(grid, way, np.gradient(curvature, way))
    # The one-sided differences at the ends are no curvature.
    slope[:2], slope[-2:], second[:3], second[-3:] = slope[2], slope[-3], second[3], second[-4]
    most = np.minimum(limits.travel.speed, limits.sight_speed(np.abs(slope)))
    return _driving(grid, np.interp(grid, way, heading), slope, second, most, limits)


def _along(pieces: Sequence[Piece], limits: DrivingLimits) -> tuple[Array, Array, Array, Array, Array]:
    """Grid, heading, its first two derivatives, and the most speed."""
    rows = [(0.0, 0.0, 0.0, 0.0, 0.0)]
    begin = turned = 0.0
    for piece in pieces:
        count = max(2, math.ceil(piece.length / LINE_STEP_M))
        if piece.parts:
            count = max(MIN_POINTS, math.ceil(piece.length / CURVE_STEP_M))
        for number in range(1, count + 1):
            s = piece.length * number / count
            phi, first, second = piece.turning(s)
            rows.append((begin + s, turned + phi, first, second, min(limits.travel.speed, piece.bound)))
        begin, turned = rows[-1][0], rows[-1][1]
    grid, heading, slope, second_, most = np.array(rows).T
    return grid, heading, slope, second_, most


def _driving(grid: Array, heading: Array, slope: Array, second: Array, most: Array, limits: DrivingLimits) -> float:
    import toppra
    import toppra.algorithm
    import toppra.constraint

    lateral = np.sqrt(limits.lateral / np.maximum(np.abs(slope), 1e-9))
    speed = np.maximum(np.minimum(most, lateral), 1e-4)
    rows = np.stack([grid, heading]), np.stack([np.ones_like(grid), slope]), np.stack([np.zeros_like(grid), second])

    class Path(toppra.interpolator.AbstractGeometricPath):  # type: ignore[misc]
        dof = 2
        path_interval = np.array([0.0, grid[-1]])
        waypoints = None

        def __call__(self, s: Array, order: int = 0) -> Array:
            return np.stack([np.interp(s, grid, row) for row in rows[order]], axis=-1)

    def velocity_limits(s: float) -> Array:
        v = float(np.interp(s, grid, speed))
        return np.array([[-v, v], [-limits.heading.speed, limits.heading.speed]])

    velocity = toppra.constraint.JointVelocityConstraintVarying(velocity_limits)
    acceleration = toppra.constraint.JointAccelerationConstraint(
        np.array(
            [
                [-limits.travel.acceleration, limits.travel.acceleration],
                [-limits.heading.acceleration, limits.heading.acceleration],
            ]
        )
    )
    toppra.setup_logging("ERROR")
    solver = toppra.algorithm.TOPPRA([velocity, acceleration], Path(), gridpoints=grid, solver_wrapper="seidel")
    _, speeds, _ = solver.compute_parameterization(0.0, 0.0)
    steps = 2.0 * np.diff(grid) / (speeds[:-1] + speeds[1:])
    return float(steps.sum())
