"""A camera that sits otherwise than its file says: the localizer finds out in a turn, and the pose is right again."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from rover.geometry import Pose2
from rover.mission.checks import FIXES, Checks
from rover.mission.fault_table import Check
from rover.vision.localization.fix import Fix
from rover.vision.localization.motion_model import MotionNoise, advance
from rover.vision.localization.pose_filter import PoseFilter

TRACK = 0.2
NOISE = np.diag(np.square((0.002, 0.002, 0.002)))


def shown(pose: Pose2, offset: tuple[float, float], stretch: float) -> Pose2:
    """What a camera with that offset makes of a pose in the first picture's frame: b - R b, and ways too long."""
    turned = Pose2(0.0, 0.0, pose.heading).transform(np.array([offset]))[0]
    x, y = (1.0 + stretch) * np.array([pose.x, pose.y]) + np.array(offset) - turned
    return Pose2(float(x), float(y), pose.heading)


def drive(offset: tuple[float, float], stretch: float, mount: tuple[float, float]) -> tuple[PoseFilter, Pose2]:
    """A whole turn on the spot, half a metre ahead, and a half turn, with a fix every few degrees and centimetres."""
    estimate, true = PoseFilter(Pose2(0.0, 0.0, 0.0), (1e-3,) * 3, (0.02, 0.02), mount), Pose2(0.0, 0.0, 0.0)
    index = estimate.add_keyframe(np.zeros((3, 3)))
    arc = 0.05 * TRACK
    ways = [(-arc, arc)] * 63 + [(0.02, 0.02)] * 25 + [(-arc, arc)] * 31
    for left, right in ways:
        estimate.propagate(*advance(estimate.mean[:8], left, right, TRACK, MotionNoise()))
        true = true.compose(Pose2(0.5 * (left + right), 0.0, (right - left) / TRACK))
        assert estimate.update(index, shown(true, offset, stretch), NOISE, 16.3)
    return estimate, true


@pytest.mark.parametrize("offset", [(0.02, 0.0), (0.0, -0.015), (-0.01, 0.01)])
@pytest.mark.parametrize("stretch", [0.0, 0.03])
def test_a_turn_tells_the_offset_and_the_pose_comes_out_within_its_bound(
    offset: tuple[float, float], stretch: float
) -> None:
    estimate, true = drive(offset, stretch, (0.012, 0.02))
    assert estimate.offset == pytest.approx(offset, abs=0.004)
    off = np.array([estimate.pose.x - true.x, estimate.pose.y - true.y])
    assert float(off @ np.linalg.solve(estimate.pose_covariance[:2, :2], off)) < 5.99
    assert np.hypot(*off) < 0.01


def test_without_it_the_same_drive_would_be_wrong_and_sure_of_itself() -> None:
    estimate, true = drive((0.012, 0.0), 0.0, (0.0, 0.0))
    off = np.array([estimate.pose.x - true.x, estimate.pose.y - true.y])
    assert float(off @ np.linalg.solve(estimate.pose_covariance[:2, :2], off)) > 5.99
    assert estimate.offset.tolist() == [0.0, 0.0]


def test_the_jacobian_of_the_expected_fix_is_that_of_small_steps() -> None:
    estimate, _ = drive((0.02, -0.01), 0.02, (0.012, 0.02))
    estimate.mean[:3] += (0.1, 0.2, 0.7)
    expected, _, jacobian = estimate.expected_fix(0)
    for column in range(len(estimate.mean)):
        estimate.mean[column] += 1e-6
        moved, _, _ = estimate.expected_fix(0)
        estimate.mean[column] -= 1e-6
        step = np.array([moved.x - expected.x, moved.y - expected.y, moved.heading - expected.heading]) / 1e-6
        assert step == pytest.approx(jacobian[:, column], abs=1e-5)


def test_a_mount_that_is_off_is_told_and_one_that_is_not_known_yet_is_not() -> None:
    def active(offset: float, sigma: float) -> bool:
        checks = Checks()
        fix = Fix(0.0, True, inliers=30, residual_px=0.7, offset=offset, offset_sigma=sigma)
        for count in range(FIXES):
            checks.take(0.1 * count, (), replace(fix, time=0.1 * count))
        return Check.MOUNT_RESIDUAL in checks.active

    assert active(0.013, 0.001)
    assert not active(0.013, 0.010)
    assert not active(0.003, 0.0005)
    assert math.isfinite(Fix(0.0, True).offset)
