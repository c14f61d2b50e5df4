"""The filter's uncertainty among keyframes: what it says of any pair, and that it does not grow with the way driven."""

from __future__ import annotations

import copy
import math

import numpy as np
import pytest
from rover.geometry import Pose2, wrap_angle
from rover.vehicle import STANDARD
from rover.vision.localization.motion_model import ROBOT, MotionNoise, advance
from rover.vision.localization.pose_filter import POSE, Moved, PoseFilter

BLUR = np.diag(np.square((0.0022, 0.0022, 0.0038)))
FIX_NOISE = np.diag(np.square((0.002, 0.002, 0.003)))


def begun() -> PoseFilter:
    return PoseFilter(Pose2(0.5, 0.5, 0.3), (0.005, 0.005, 0.01), (0.02, 0.02))


def roll(estimate: PoseFilter, left: float, right: float) -> None:
    estimate.propagate(*advance(estimate.mean[:ROBOT], left, right, STANDARD.track_width, MotionNoise()))


def wandering(seed: int) -> PoseFilter:
    """A filter after random drives, keyframes and fixes against any of them."""
    rng = np.random.default_rng(seed)
    estimate = begun()
    for _ in range(40):
        roll(estimate, *rng.uniform(-0.05, 0.2, 2).tolist())
        if rng.random() < 0.25:
            estimate.add_keyframe(BLUR)
        elif estimate.keyframes and rng.random() < 0.5:
            index = int(rng.integers(estimate.keyframes))
            at, _, _ = estimate.expected_fix(index)
            dx, dy, turn = (rng.standard_normal(3) * np.sqrt(np.diag(FIX_NOISE))).tolist()
            estimate.update(index, Pose2(at.x + dx, at.y + dy, at.heading + turn), FIX_NOISE)
    return estimate


def by_differences(estimate: PoseFilter, index: int) -> np.ndarray:
    """Covariance (3, 3) of the rover in a keyframe's frame from the whole state's, by a numerical Jacobian."""

    def relative(state: np.ndarray) -> np.ndarray:
        at = ROBOT + POSE * index
        pose = Pose2(*state[:POSE].tolist()).relative_to(Pose2(*state[at : at + POSE].tolist()))
        return np.array([pose.x, pose.y, pose.heading])

    size, step = len(estimate.mean), 1e-6
    jacobian = np.zeros((POSE, size))
    for column in range(size):
        nudge = np.zeros(size)
        nudge[column] = step
        change = relative(estimate.mean + nudge) - relative(estimate.mean - nudge)
        change[2] = wrap_angle(change[2])
        jacobian[:, column] = change / (2.0 * step)
    return jacobian @ estimate.covariance @ jacobian.T


@pytest.mark.parametrize("seed", range(5))
def test_what_it_says_of_a_pair_is_what_the_whole_state_says(seed: int) -> None:
    estimate = wandering(seed)
    assert estimate.keyframes > 2
    for index in range(estimate.keyframes):
        np.testing.assert_allclose(
            estimate.relative_covariance(index), by_differences(estimate, index), rtol=1e-4, atol=1e-12
        )


@pytest.mark.parametrize("seed", range(5))
def test_after_more_wheel_travel_it_is_as_if_the_filter_itself_had_moved(seed: int) -> None:
    estimate = wandering(seed)
    rng = np.random.default_rng(seed)
    moved = Moved(estimate.mean[:ROBOT].copy(), np.eye(ROBOT), np.zeros((ROBOT, ROBOT)))
    later = copy.deepcopy(estimate)
    for left, right in rng.uniform(-0.02, 0.05, (6, 2)).tolist():
        moved = moved.then(*advance(moved.robot, left, right, STANDARD.track_width, MotionNoise()))
        roll(later, left, right)
    for index in range(estimate.keyframes):
        np.testing.assert_allclose(
            estimate.relative_covariance(index, moved), later.relative_covariance(index), rtol=1e-9, atol=1e-15
        )


def test_on_a_long_way_the_place_in_map_gets_vague_and_the_place_among_the_ground_does_not() -> None:
    estimate = begun()
    relative, absolute = [], []
    for metre in range(12):
        index = estimate.add_keyframe(BLUR)
        for _ in range(5):
            roll(estimate, 0.1, 0.1)
            estimate.update(index, estimate.expected_fix(index)[0], FIX_NOISE)
        for _ in range(5):
            roll(estimate, 0.1, 0.1)
        if metre:
            relative.append(math.sqrt(float(estimate.relative_covariance(index)[:2, :2].trace())))
            absolute.append(math.sqrt(float(estimate.robot_covariance[:2, :2].trace())))
    assert absolute[-1] > 3.0 * absolute[0]
    assert relative[-1] <= 1.1 * relative[0]
