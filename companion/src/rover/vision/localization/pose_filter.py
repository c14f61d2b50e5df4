"""The estimator: an extended Kalman filter over the rover, its wheels' slip, the camera's mount, and every keyframe.

State: x, y, heading (map), two numbers of how the rover moves, three of the camera, then x, y, heading of each
keyframe. With wheels the two of motion are the slip of the left and the right one (share of the reported travel that is
not real); without, they are speed and turn rate. The camera's are for one that sits otherwise than its file says: how
far ahead and to the left of where it is it shows the ground (a degree of pitch: 2 cm), which a turn on the spot tells,
in which the wheels say that the rover stays; and the share by which it shows ways too long (3 %), which straight ways
tell as turns tell the slip.

Keyframes are clones of the pose that the rover had, with all correlations, so that a fix against a keyframe counts for
what it is, a relative measurement, however often the keyframe is seen; a return to an old keyframe also mends the newer
ones. (Stochastic cloning: Roumeliotis and Burdick, ICRA 2002.)
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rover.geometry import Pose2, wrap_angle
from rover.vision.localization.motion_model import OFFSET, ROBOT

Array = NDArray[np.float64]

POSE = 3


@dataclass(frozen=True, eq=False)
class Moved:
    """The rover after some motion: robot (8,), the Jacobian (8, 8) of that motion and the noise (8, 8) it added."""

    robot: Array
    jacobian: Array
    added: Array

    def then(self, robot: Array, jacobian: Array, added: Array) -> Moved:
        """After one step more."""
        return Moved(robot, jacobian @ self.jacobian, jacobian @ self.added @ jacobian.T + added)


class PoseFilter:
    """Mean and covariance of robot and keyframes at one moment. Angles of the mean are not wrapped."""

    def __init__(
        self,
        start: Pose2,
        start_sigma: tuple[float, float, float],
        motion_sigma: tuple[float, float],
        mount_sigma: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        """`mount_sigma`: of the camera's offset along either axis, metres, and of its stretch; 0: as its file says."""
        offset, stretch = mount_sigma
        self.mean: Array = np.array([start.x, start.y, start.heading, *(0.0,) * (ROBOT - POSE)])
        self.covariance: Array = np.diag(np.square([*start_sigma, *motion_sigma, offset, offset, stretch]))

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
        """(8, 8): x, y, heading, slips, the camera's offset and stretch."""
        covariance: Array = self.covariance[:ROBOT, :ROBOT].copy()
        return covariance

    @property
    def pose_covariance(self) -> Array:
        """(3, 3) of x, y, heading."""
        covariance: Array = self.covariance[:POSE, :POSE].copy()
        return covariance

    @property
    def offset(self) -> Array:
        """(2,): how far ahead and to the left the camera shows the ground of where it is, metres."""
        offset: Array = self.mean[OFFSET : OFFSET + 2].copy()
        return offset

    @property
    def mount(self) -> tuple[Array, Array]:
        """Offset and stretch (3,), and their covariance (3, 3)."""
        return self.mean[OFFSET:ROBOT].copy(), self.covariance[OFFSET:ROBOT, OFFSET:ROBOT].copy()

    @mount.setter
    def mount(self, known: tuple[Array, Array]) -> None:
        self.mean[OFFSET:ROBOT], self.covariance[OFFSET:ROBOT, OFFSET:ROBOT] = known

    @property
    def offset_covariance(self) -> Array:
        """(2, 2)."""
        covariance: Array = self.covariance[OFFSET : OFFSET + 2, OFFSET : OFFSET + 2].copy()
        return covariance

    def covariance_of(self, index: int) -> Array:
        """(3, 3) of a keyframe's x, y, heading."""
        at = ROBOT + POSE * index
        covariance: Array = self.covariance[at : at + POSE, at : at + POSE].copy()
        return covariance

    def keyframe_pose(self, index: int) -> Pose2:
        """The present estimate of a keyframe's pose in the map."""
        at = ROBOT + POSE * index
        x, y, heading = self.mean[at : at + POSE].tolist()
        return Pose2(x, y, wrap_angle(heading))

    def keyframe_poses(self) -> Array:
        """All keyframes, (K, 3)."""
        return self.mean[ROBOT:].reshape(-1, POSE)

    @property
    def keyframe_covariance(self) -> Array:
        """Of all keyframes' x, y, heading, (3K, 3K)."""
        covariance: Array = self.covariance[ROBOT:, ROBOT:].copy()
        return covariance

    def propagate(self, robot: Array, jacobian: Array, added: Array) -> None:
        """The robot moves to `robot` (5,); `jacobian` and `added` (8, 8) as composed over all steps in between."""
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

    def add_known(self, poses: Array, covariance: Array) -> None:
        """Adds keyframes (K, 3) of another run with their covariance (3K, 3K): nothing of the rover's own pose."""
        size, more = len(self.mean), poses.size
        grown = np.zeros((size + more, size + more))
        grown[:size, :size] = self.covariance
        grown[size:, size:] = covariance
        self.mean, self.covariance = np.concatenate((self.mean, poses.ravel())), grown

    def expected_fix(self, index: int) -> tuple[Pose2, Array, Array]:
        """The rover's pose in the frame of a keyframe, as the camera shows it: both pictures are off by its offset b,
        each in its own axes, so that a turn by R between them looks like a shift of b - R b; ways are stretched.

        Mean, covariance (3, 3), Jacobian (3, size of the state).
        """
        at = ROBOT + POSE * index
        relative, of_rover, of_keyframe = relative_pose(self.pose, self.keyframe_pose(index))
        jacobian = np.zeros((POSE, len(self.mean)))
        if self.covariance[OFFSET, OFFSET] > 0.0:
            ahead, left = self.offset.tolist()
            longer = 1.0 + float(self.mean[OFFSET + 2])
            x, y, turn = relative.x, relative.y, relative.heading
            c, s = math.cos(turn), math.sin(turn)
            relative = Pose2(longer * x + ahead - c * ahead + s * left, longer * y + left - s * ahead - c * left, turn)
            by_turn = np.array([s * ahead + c * left, s * left - c * ahead])
            of_rover[:2] *= longer
            of_keyframe[:2] *= longer
            of_rover[:2, 2] += by_turn
            of_keyframe[:2, 2] -= by_turn
            jacobian[:2, OFFSET:ROBOT] = [[1.0 - c, s, x], [-s, 1.0 - c, y]]
        jacobian[:, :POSE] = of_rover
        jacobian[:, at : at + POSE] = of_keyframe
        return relative, jacobian @ self.covariance @ jacobian.T, jacobian

    def relative_covariance(self, index: int, moved: Moved | None = None) -> Array:
        """(3, 3) of the rover's pose in the frame of a keyframe, in the keyframe's axes.

        moved: what the rover has done since the filter's time, when it is asked for the pose after that.
        """
        at = ROBOT + POSE * index
        moved = moved or Moved(self.mean[:ROBOT], np.eye(ROBOT), np.zeros((ROBOT, ROBOT)))
        x, y, heading = moved.robot[:POSE].tolist()
        _, of_rover, of_keyframe = relative_pose(Pose2(x, y, heading), self.keyframe_pose(index))
        step = of_rover @ moved.jacobian[:POSE]
        cross = step @ self.covariance[:ROBOT, at : at + POSE] @ of_keyframe.T
        covariance: Array = (
            step @ self.covariance[:ROBOT, :ROBOT] @ step.T
            + of_rover @ moved.added[:POSE, :POSE] @ of_rover.T
            + cross
            + cross.T
            + of_keyframe @ self.covariance[at : at + POSE, at : at + POSE] @ of_keyframe.T
        )
        return covariance

    def innovation(self, index: int, fix: Pose2, noise: Array) -> tuple[Array, float]:
        """Fix minus expectation (3,), and its squared Mahalanobis length (chi-square, three degrees)."""
        relative, expected, _ = self.expected_fix(index)
        off = difference(fix, relative)
        return off, float(off @ np.linalg.solve(expected + noise, off))

    def update(self, index: int, fix: Pose2, noise: Array, gate: float = math.inf) -> bool:
        """Takes a fix in: the rover was seen at `fix` in the keyframe's frame, with covariance `noise` (3, 3).

        False, and nothing is changed, where the squared Mahalanobis length of the innovation exceeds `gate`.
        """
        relative, expected, jacobian = self.expected_fix(index)
        off = difference(fix, relative)
        by_jacobian = jacobian @ self.covariance
        solved = np.linalg.solve(expected + noise, np.column_stack((off, by_jacobian)))
        if float(off @ solved[:, 0]) > gate:
            return False
        gain = solved[:, 1:].T
        self.mean = self.mean + gain @ off
        self.covariance -= gain @ by_jacobian
        self.covariance = 0.5 * (self.covariance + self.covariance.T)
        return True

    def doubt(self, sigma: tuple[float, float, float]) -> None:
        """Grows the covariance of x, y (m) and heading (rad): a frame has contradicted what is believed."""
        self.covariance[:POSE, :POSE] += np.diag(np.square(sigma))

    def stop(self, sigma: tuple[float, float]) -> None:
        """Forgets how the rover moves: both numbers 0, of these standard deviations."""
        self.mean[POSE:OFFSET] = 0.0
        self.covariance[POSE:OFFSET, :] = 0.0
        self.covariance[:, POSE:OFFSET] = 0.0
        self.covariance[POSE:OFFSET, POSE:OFFSET] = np.diag(np.square(sigma))

    def take_motion(self, other: PoseFilter) -> None:
        """Takes over from the filter of another submap how the rover moves and how its camera sits; not where it is."""
        self.mean[POSE:ROBOT] = other.mean[POSE:ROBOT]
        self.covariance[POSE:ROBOT, :] = 0.0
        self.covariance[:, POSE:ROBOT] = 0.0
        self.covariance[POSE:ROBOT, POSE:ROBOT] = other.covariance[POSE:ROBOT, POSE:ROBOT]

    def relocate(self, index: int, fix: Pose2, noise: Array) -> None:
        """Places the rover by a fix alone: what was believed about its pose is dropped, all else stays."""
        placed = self.keyframe_pose(index).compose(fix)
        self.mean[:3] = (placed.x, placed.y, placed.heading)
        self.covariance[:3, :] = 0.0
        self.covariance[:, :3] = 0.0
        self.covariance[:3, :3] = np.diag((1e2, 1e2, 1e1))
        self.update(index, fix, noise)


def relative_pose(pose: Pose2, key: Pose2) -> tuple[Pose2, Array, Array]:
    """`pose` in the frame of `key`, with its Jacobians (3, 3) by either, both given in map."""
    relative = pose.relative_to(key)
    c, s = math.cos(key.heading), math.sin(key.heading)
    of_pose = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    of_key = np.array([[-c, -s, relative.y], [s, -c, -relative.x], [0.0, 0.0, -1.0]])
    return relative, of_pose, of_key


def difference(fix: Pose2, expected: Pose2) -> Array:
    """`fix` minus `expected`, (3,), the heading wrapped."""
    return np.array([fix.x - expected.x, fix.y - expected.y, wrap_angle(fix.heading - expected.heading)])
