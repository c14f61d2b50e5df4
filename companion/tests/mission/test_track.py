"""The record of where the rover thought it was."""

from __future__ import annotations

import math

import numpy as np
import pytest
from rover.geometry import Pose2
from rover.mission.track import Track


def test_an_empty_track_has_no_pose_and_no_length() -> None:
    track = Track()
    assert (track.duration, track.distance) == (0.0, 0.0)
    assert (track.final_pose, track.final_sigma, track.max_sigma) == (None, None, None)
    assert track.fused.shape == track.wheels.shape == (0, 4)


def test_rows_are_time_x_y_heading_of_both_estimates() -> None:
    track = Track()
    track.add(2.0, Pose2(1.0, 2.0, 0.1), Pose2(1.1, 2.1, 0.2), 0.02, 0.004)
    np.testing.assert_array_equal(track.fused, [[2.0, 1.0, 2.0, 0.1]])
    np.testing.assert_array_equal(track.wheels, [[2.0, 1.1, 2.1, 0.2]])


def test_duration_and_distance_are_those_of_the_way_driven() -> None:
    track = Track()
    for cycle in range(201):
        track.add(5.0 + 0.02 * cycle, Pose2(0.005 * cycle, 1.0, 0.0), Pose2(0.0, 0.0, 0.0), 0.01, 0.004)
    assert track.duration == pytest.approx(4.0)
    assert track.distance == pytest.approx(1.0)


def test_what_the_estimate_trembles_while_the_rover_stands_is_not_summed_cycle_by_cycle() -> None:
    track = Track()
    for cycle in range(1001):
        track.add(0.02 * cycle, Pose2(1.0 + (0.001 if cycle % 5 == 2 else 0.0), 1.0, 0.0), Pose2(0, 0, 0), 0.01, 0.004)
    assert track.distance == pytest.approx(0.0)


def test_the_final_pose_has_a_heading_within_half_a_turn_and_the_worst_sigma_is_kept() -> None:
    track = Track()
    for now, sigma in ((0.0, 0.01), (0.02, 0.05), (0.04, 0.02)):
        track.add(now, Pose2(1.0, 2.0, 3.0 * math.pi), Pose2(0.0, 0.0, 0.0), sigma, 0.004)
    assert track.final_pose is not None
    assert abs(track.final_pose.heading) == pytest.approx(math.pi)
    assert (track.final_sigma, track.max_sigma, track.max_relative_sigma) == (0.02, 0.05, 0.004)


def test_before_the_rover_knows_where_it_is_there_is_no_pose_and_the_clock_runs() -> None:
    track = Track()
    for now, sigma in ((1.0, 10.0), (1.02, 10.0), (1.04, 0.01), (1.06, 0.01)):
        track.add(now, Pose2(1.0, 2.0, 0.0), Pose2(0.0, 0.0, 0.0), sigma, 0.004)
    assert track.fused[:, 0].tolist() == [1.04, 1.06]
    assert track.start == 1.0
    assert track.duration == pytest.approx(0.06)
    assert track.max_sigma == 0.01
