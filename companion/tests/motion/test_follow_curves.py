"""The follower where corners may be rounded: on the curve, within the limits, and quicker than turning on the spot."""

from __future__ import annotations

import math

import numpy as np
import pytest
from rover.geometry import Pose2
from rover.motion import CommittedMotion, PathFollower, State
from rover.motion.following.curve import together
from rover.motion.path.clearance import ClearanceMap
from rover.planning.fields import CircleField
from rover.vehicle import Limits, Vehicle

from companion.tests.motion.motion_limits import assert_within_limits
from companion.tests.motion.motion_simulation import drive

OPEN = ClearanceMap(lambda points: np.full(len(points), 1.0))
WINDING = [(0.0, 0.0), (1.0, 0.0), (1.6, 0.8), (2.6, 0.9), (2.2, 0.4), (2.0, -0.5), (1.0, -1.0)]
NOISE = (0.01, 0.01)


def blended(path, clearance=OPEN):
    """The points that are to be driven, without repetitions."""
    follower = PathFollower(Vehicle())
    follower.follow(path, None, clearance)
    points = follower.path
    return [point for n, point in enumerate(points) if n == 0 or math.dist(point, points[n - 1]) > 1e-6]


def test_without_slip_or_noise_the_curves_are_driven_to_three_millimetres():
    follower, committed, log = drive(WINDING, clearance=OPEN)
    assert log.finished
    assert not follower.lost
    assert log.restarts == 0
    assert log.off_path(blended(WINDING)) < 0.003
    assert committed.end_state.at_rest
    assert math.dist((log.poses[-1].x, log.poses[-1].y), WINDING[-1]) < 0.008


@pytest.mark.parametrize("wheels", [(0.97, 0.95), (0.95, 0.97), (0.9, 0.93)])
def test_slip_and_noise_keep_within_three_centimetres_of_the_curves(wheels):
    for seed in range(2):
        follower, _, log = drive(WINDING, wheels=wheels, noise=NOISE, seed=seed, clearance=OPEN)
        assert log.finished
        assert not follower.lost
        assert log.off_path(blended(WINDING)) < 0.03


def test_the_limits_of_the_vehicle_hold_for_curve_and_steering_together():
    _, _, log = drive(WINDING, wheels=(0.97, 0.95), noise=NOISE, clearance=OPEN)
    slack = 1.02  # speed: where the estimate jumps while the rover speeds up
    travel = Limits(*(slack * value for value in (0.25, 0.5, 3.0)))
    heading = Limits(*(slack * value for value in (1.2, 3.0, 8.0)))
    run: list = []
    for segment in log.segments:
        run.append(segment)
        if segment.rest:
            assert_within_limits(run, State(), travel, heading)
            run = []


def test_rounding_saves_a_quarter_of_the_time():
    rounded = drive(WINDING, wheels=(0.97, 0.95), noise=NOISE, clearance=OPEN)[2]
    turned = drive(WINDING, wheels=(0.97, 0.95), noise=NOISE)[2]
    assert rounded.times[-1] < 0.75 * turned.times[-1]


def test_only_a_few_tenths_of_a_second_are_committed_ahead_on_curves_too():
    follower, _, log = drive(WINDING, wheels=(0.97, 0.95), noise=NOISE, clearance=OPEN)
    assert log.most_ahead <= follower.committed_at_most


def test_where_the_map_has_no_room_the_corner_is_turned_on_the_spot():
    walls = ClearanceMap(lambda points: np.where(points[:, 1] < 0.01, 1.0, -1.0))
    straight_up = [(0.0, 0.0), (1.0, 0.0), (1.0, -1.0)]
    assert len(blended(straight_up, walls)) > 5
    tight = ClearanceMap(lambda points: np.zeros(len(points)))
    _, _, log = drive(straight_up, clearance=tight)
    assert log.finished
    assert log.off_path(straight_up) < 0.01


@pytest.mark.parametrize("moment", [3.5, 4.5, 5.5, 7.0])
def test_a_stop_in_the_middle_of_a_curve_comes_to_rest_within_the_limits(moment):
    follower, committed, log = drive(WINDING, stop_at=moment, clearance=OPEN)
    assert log.finished
    assert follower.stopped
    assert committed.end_state.at_rest
    assert log.times[-1] - moment < follower.committed_at_most + 1.2


def test_pushed_off_a_curve_the_rover_stops_and_asks_for_a_new_path():
    follower, committed, log = drive(WINDING, push_at=4.0, clearance=OPEN)
    assert log.finished
    assert follower.lost
    assert committed.end_state.at_rest


def test_when_no_profile_exists_on_curves_the_rover_stops_and_gives_up():
    follower = PathFollower(Vehicle(), Limits(0.0, 0.5, 3.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        _, committed, log = drive(WINDING, follower=follower, clearance=OPEN)
    assert log.finished
    assert follower.lost
    assert committed.end_state.at_rest


def test_the_speed_falls_where_the_map_is_tighter_than_was_planned_for():
    field = CircleField(4.0, 2.0, [(2.0, 1.22, 0.1), (2.0, 0.78, 0.1)])
    narrow = ClearanceMap.of(field, 0.15)
    pose = [(0.4, 1.0), (3.6, 1.0)]
    _, _, log = drive(pose, start=Pose2(0.4, 1.0, 0.0), clearance=narrow)
    through = [v for p, v in zip(log.poses, log.speeds, strict=True) if 1.9 < p.x < 2.1]
    elsewhere = [v for p, v in zip(log.poses, log.speeds, strict=True) if 0.9 < p.x < 1.3]
    assert min(through) < 0.2
    assert max(elsewhere) > 0.24


def test_the_same_calls_give_the_same_segments_on_curves():
    first = drive(WINDING, noise=NOISE, seed=3, clearance=OPEN)[2].segments
    assert first == drive(WINDING, noise=NOISE, seed=3, clearance=OPEN)[2].segments


def test_rows_of_jerk_that_run_together_add_up():
    rows = together(((1.0, 2.0), (1.0, -2.0)), ((0.5, 1.0), (3.0, 4.0)))
    assert np.array(rows) == pytest.approx(np.array([[0.5, 3.0], [0.5, 6.0], [1.0, 2.0], [1.5, 4.0]]))


def test_an_empty_record_of_motion_is_no_obstacle_to_a_new_path():
    follower = PathFollower(Vehicle())
    follower.follow([(0.0, 0.0)], 0.5, OPEN)
    segments = follower.next_segments(0.0, Pose2(0.0, 0.0, 0.0), CommittedMotion())
    assert segments
    assert all(segment.jerk_travel == 0 for segment in segments)
