"""The estimator: an extended Kalman filter over the rover, its wheels' slip, and the pose of every keyframe.

State: x, y, heading (map), slip of the left and the right wheel (share of the reported travel that is not real),
then x, y, heading of each keyframe. Keyframes are clones of the pose that the rover had, with all correlations, so
that a fix against a keyframe counts for what it is, a relative measurement, however often the keyframe is seen; a
return to an old keyframe also mends the newer ones. (Stochastic cloning: Roumeliotis and Burdick, ICRA 2002.)
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rover.geometry import Pose2, wrap_angle

Array = NDArray[np.float64]

ROBOT = 5
POSE = 3


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
    """One wheel report: the new robot state (5,), its Jacobian (5, 5) and the added noise (5, 5).

    left_m, right_m: travel as the wheels report it; what is real is 1 - slip of it. Midpoint integration.
    """
    x, y, heading, slip_left, slip_right = robot.tolist()
    left, right = left_m * (1.0 - slip_left), right_m * (1.0 - slip_right)
    ahead, turn = 0.5 * (left + right), (right - left) / track
    middle = heading + 0.5 * turn
    c, s = math.cos(middle), math.sin(middle)
    new = np.array([x + ahead * c, y + ahead * s, heading + turn, slip_left, slip_right])
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


class PoseFilter:
    """Mean and covariance of robot and keyframes at one moment. Angles of the mean are not wrapped."""

    def __init__(self, start: Pose2, start_sigma: tuple[float, float, float], noise: MotionNoise) -> None:
        self.noise = noise
        self.mean: Array = np.array([start.x, start.y, start.heading, 0.0, 0.0])
        sigma = np.array([*start_sigma, noise.slip_start, noise.slip_start])
        self.covariance: Array = np.diag(sigma**2)

    @property
    def keyframes(self) -> int:
        """Number of keyframes in the state."""
        return (len(self.mean) - ROBOT) // POSE

    @property
    def pose(self) -> Pose2:
        """The rover's pose in the map."""
        x, y, heading = self.mean[:3].tolist()
        return Pose2(x, y, wrap_angle(heading))

    @property
    def robot_covariance(self) -> Array:
        """(5, 5): x, y, heading, slips."""
        return self.covariance[:ROBOT, :ROBOT].copy()

    def keyframe_pose(self, index: int) -> Pose2:
        """The present estimate of a keyframe's pose in the map."""
        at = ROBOT + POSE * index
        x, y, heading = self.mean[at : at + POSE].tolist()
        return Pose2(x, y, wrap_angle(heading))

    def keyframe_poses(self) -> Array:
        """All keyframes, (K, 3)."""
        return self.mean[ROBOT:].reshape(-1, POSE)

    def propagate(self, robot: Array, jacobian: Array, added: Array) -> None:
        """The robot moves to `robot` (5,); `jacobian` and `added` (5, 5) as composed over all steps in between."""
        self.mean[:ROBOT] = robot
        p = self.covariance
        p[:ROBOT, :ROBOT] = jacobian @ p[:ROBOT, :ROBOT] @ jacobian.T + added
        cross = jacobian @ p[:ROBOT, ROBOT:]
        p[:ROBOT, ROBOT:] = cross
        p[ROBOT:, :ROBOT] = cross.T

    def add_keyframe(self, blur: Array) -> int:
        """Clones the robot's pose as a keyframe; returns its index.

        blur: (3, 3), how far the keyframe's own features may be off as a whole: without it the noise of the one
        picture would be taken for new at each fix against it.
        """
        size = len(self.mean)
        pick = np.vstack((np.eye(size), np.eye(POSE, size)))
        self.mean = pick @ self.mean
        self.covariance = pick @ self.covariance @ pick.T
        self.covariance[size:, size:] += blur
        return (size - ROBOT) // POSE

    def drop_keyframe(self, index: int) -> None:
        """Forgets a keyframe; those after it move up by one."""
        at = ROBOT + POSE * index
        keep = np.r_[0:at, at + POSE : len(self.mean)]
        self.mean = self.mean[keep]
        self.covariance = self.covariance[np.ix_(keep, keep)]

    def expected_fix(self, index: int) -> tuple[Pose2, Array, Array]:
        """The rover's pose in the frame of a keyframe: mean, covariance (3, 3), Jacobian (3, size of the state)."""
        at = ROBOT + POSE * index
        key = self.keyframe_pose(index)
        relative = self.pose.relative_to(key)
        c, s = math.cos(key.heading), math.sin(key.heading)
        jacobian = np.zeros((POSE, len(self.mean)))
        jacobian[:, :3] = [[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]
        jacobian[:, at : at + POSE] = [[-c, -s, relative.y], [s, -c, -relative.x], [0.0, 0.0, -1.0]]
        return relative, jacobian @ self.covariance @ jacobian.T, jacobian

    def innovation(self, index: int, fix: Pose2, noise: Array) -> tuple[Array, float]:
        """Fix minus expectation (3,), and its squared Mahalanobis length (chi-square, three degrees)."""
        relative, expected, _ = self.expected_fix(index)
        difference = np.array(
            [fix.x - relative.x, fix.y - relative.y, wrap_angle(fix.heading - relative.heading)]
        )
        return difference, float(difference @ np.linalg.solve(expected + noise, difference))

    def update(self, index: int, fix: Pose2, noise: Array) -> None:
        """Takes a fix in: the rover was seen at `fix` in the keyframe's frame, with covariance `noise` (3, 3)."""
        difference, _ = self.innovation(index, fix, noise)
        _, expected, jacobian = self.expected_fix(index)
        gain = np.linalg.solve(expected + noise, jacobian @ self.covariance).T
        self.mean = self.mean + gain @ difference
        self.covariance -= gain @ (jacobian @ self.covariance)
        self.covariance = 0.5 * (self.covariance + self.covariance.T)

    def relocate(self, index: int, fix: Pose2, noise: Array) -> None:
        """Places the rover by a fix alone: what was believed about its pose is dropped, slips and keyframes stay."""
        placed = self.keyframe_pose(index).compose(fix)
        self.mean[:3] = (placed.x, placed.y, placed.heading)
        self.covariance[:3, :] = 0.0
        self.covariance[:, :3] = 0.0
        self.covariance[:3, :3] = np.diag((1e2, 1e2, 1e1))
        self.update(index, fix, noise)
