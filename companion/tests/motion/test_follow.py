"""The follower in closed loop on a rover that slips and whose estimate is noisy."""

from __future__ import annotations

import math

import pytest
from rover.errors import BadInput
from rover.geometry import Pose2, wrap_angle
from rover.motion import CommittedMotion, FollowerSettings, PathFollower, State
from rover.vehicle import Limits, Vehicle

from companion.tests.motion.motion_limits import assert_within_limits
from companion.tests.motion.motion_simulation import drive

ZIGZAG = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (1.8, 1.1), (2.0, 2.0), (0.5, 2.0)]
NOISE = (0.01, 0.01)


def runs(segments):
    """The segments cut into runs."""
    found = []
    for segment in segments:
        if segment.begin:
            found.append([])
        found[-1].append(segment)
    return found


def test_without_slip_or_noise_the_path_is_driven_to_the_millimetre():
    follower, committed, log = drive(ZIGZAG, final_heading=0.5)
    assert log.finished
    assert follower.done
    assert not follower.stopped
    assert log.off_path(ZIGZAG) < 0.008
    end = log.poses[-1]
    assert math.dist((end.x, end.y), ZIGZAG[-1]) < 0.008
    assert abs(wrap_angle(end.heading - 0.5)) < 0.04
    assert committed.end_state.at_rest


@pytest.mark.parametrize("wheels", [(0.97, 0.95), (0.95, 0.97), (0.96, 0.96), (1.0, 1.0)])
def test_slip_of_three_to_five_percent_keeps_within_two_and_a_half_centimetres(wheels):
    path = [(0.0, 0.0), (2.0, 0.0)]
    for seed in range(4):
        _, _, log = drive(path, wheels=wheels, noise=NOISE, seed=seed)
        assert log.finished
        assert log.restarts == 0
        assert log.off_path(path) < 0.025
        assert math.dist((log.poses[-1].x, log.poses[-1].y), path[-1]) < 0.03


def test_corners_are_turned_on_the_spot_and_every_run_goes_from_rest_to_rest():
    _, _, log = drive(ZIGZAG, wheels=(0.97, 0.95), noise=NOISE)
    assert log.finished
    assert log.off_path(ZIGZAG) < 0.03
    for segments in runs(log.segments):
        assert segments[0].begin
        assert segments[-1].rest
        assert sum(segment.rest for segment in segments) == 1
        assert_within_limits(segments, State())
        turning = all(segment.jerk_travel == 0 for segment in segments)
        assert turning or len(segments) > 5


def test_soft_corners_are_driven_through():
    path = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.1)]
    _, _, log = drive(path, noise=NOISE)
    assert len(runs(log.segments)) == 1
    assert log.off_path(path) < 0.025


def test_a_heading_error_left_by_a_turn_is_corrected_before_driving():
    follower, _, log = drive([(0.0, 0.0), (0.0, 1.0)], wheels=(0.9, 0.9))
    headings = [pose.heading for pose, speed in zip(log.poses, log.speeds, strict=True) if 0.0 < speed < 0.02]
    assert abs(headings[0] - math.pi / 2) < math.radians(2.5)
    assert follower.slip.turn < 0.96  # and the next turn knows


def test_only_a_few_tenths_of_a_second_are_committed_ahead():
    follower, _, log = drive(ZIGZAG, wheels=(0.97, 0.95), noise=NOISE)
    assert log.most_ahead <= follower.committed_at_most
    assert follower.committed_at_most <= 0.9


def test_the_queue_of_the_firmware_never_fills():
    _, _, log = drive(ZIGZAG, noise=NOISE)
    shortest_second = 0
    total, window = 0, []
    for segment in log.segments:
        window.append(segment.duration_us)
        total += segment.duration_us
        while total > 1_000_000:
            total -= window.pop(0)
        shortest_second = max(shortest_second, len(window))
    assert shortest_second < 48  # of 64 slots, and less than a second is queued


@pytest.mark.parametrize("moment", [0.3, 1.0, 2.1, 3.3])
def test_a_requested_stop_comes_to_rest_within_the_limits(moment):
    follower, committed, log = drive([(0.0, 0.0), (0.0, 2.0)], stop_at=moment)
    assert log.finished
    assert follower.stopped
    assert committed.end_state.at_rest
    assert log.times[-1] - moment < follower.committed_at_most + 1.2
    for segments in runs(log.segments):
        assert_within_limits(segments, State())


def test_after_a_stop_a_new_path_can_be_followed():
    follower, _, log = drive([(0.0, 0.0), (2.0, 0.0)], stop_at=2.0)
    at = log.poses[-1]
    _, _, log = drive([(at.x, at.y), (at.x, 0.5)], start=at, follower=follower)
    assert log.finished
    assert not follower.stopped
    assert abs(log.poses[-1].y - 0.5) < 0.01


def test_pushed_off_the_path_the_rover_stops_and_asks_for_a_new_one():
    follower, committed, log = drive([(0.0, 0.0), (2.0, 0.0)], push_at=3.0)
    assert log.finished
    assert follower.lost
    assert follower.done
    assert committed.end_state.at_rest
    assert log.times[-1] - 3.0 < follower.committed_at_most + 1.0
    for segments in runs(log.segments):
        assert_within_limits(segments, State())


def test_twisted_by_a_push_the_rover_stops_before_it_is_far_off():
    follower, _, log = drive([(0.0, 0.0), (2.0, 0.0)], twist_at=3.0)
    assert follower.lost
    assert log.off_path([(0.0, 0.0), (2.0, 0.0)]) < 0.25


def test_when_no_profile_exists_the_rover_stops_and_gives_up_after_a_few_tries():
    follower = PathFollower(Vehicle(), Limits(0.0, 0.5, 3.0))
    _, committed, log = drive([(0.0, 0.0), (2.0, 0.0)], follower=follower)
    assert log.finished
    assert follower.lost
    assert follower.restarts == FollowerSettings().max_restarts + 1
    assert committed.end_state.at_rest


def test_the_speed_limit_of_a_place_is_kept_there():
    def limit(x: float, y: float) -> float:
        return 0.1 if 0.8 < x < 1.2 else 0.25

    follower = PathFollower(Vehicle(), speed_limit=limit)
    _, _, log = drive([(0.0, 0.0), (2.0, 0.0)], follower=follower)
    slow = [s for pose, s in zip(log.poses, log.speeds, strict=True) if 0.85 < pose.x < 1.15]
    fast = [s for pose, s in zip(log.poses, log.speeds, strict=True) if 0.3 < pose.x < 0.6]
    assert max(slow) < 0.105
    assert max(fast) > 0.24


def test_a_constant_speed_limit_is_kept():
    follower = PathFollower(Vehicle(), speed_limit=0.12)
    _, _, log = drive([(0.0, 0.0), (1.0, 0.0)], follower=follower)
    assert 0.115 < max(log.speeds) < 0.121


def test_the_same_calls_give_the_same_segments():
    first = drive(ZIGZAG, noise=NOISE, seed=3)[2].segments
    again = drive(ZIGZAG, noise=NOISE, seed=3)[2].segments
    assert first == again


@pytest.mark.parametrize("path", [[], [(0.0, 0.0)], [(0.0, 0.0), (0.0, 0.0)]])
def test_a_path_that_leads_nowhere_only_turns_to_the_final_heading(path):
    _, _, log = drive(path, final_heading=1.0)
    assert log.finished
    assert abs(log.poses[-1].heading - 1.0) < 0.04
    assert all(segment.jerk_travel == 0 for segment in log.segments)


def test_a_path_that_is_not_finite_is_bad_input():
    with pytest.raises(BadInput, match="not finite"):
        PathFollower(Vehicle()).follow([(0.0, 0.0), (math.nan, 1.0)])


def test_an_estimate_that_is_not_finite_stops_the_rover():
    follower = PathFollower(Vehicle())
    follower.follow([(0.0, 0.0), (2.0, 0.0)])
    committed = CommittedMotion()
    now = 0.0
    while committed.end_state.speed < 0.2:
        segments = follower.next_segments(now, Pose2(committed.state_at(now).travel, 0.0, 0.0), committed)
        if segments:
            committed.append(segments, 0.1 if segments[0].begin else None)
        now += 0.02
    for _ in range(200):
        segments = follower.next_segments(now, Pose2(math.nan, 0.0, 0.0), committed)
        if segments:
            committed.append(segments)
        now += 0.02
    assert committed.end_state.at_rest
    assert follower.stopped


def test_settings_can_be_chosen():
    follower = PathFollower(Vehicle(), settings=FollowerSettings(horizon=0.4))
    _, _, log = drive([(0.0, 0.0), (1.0, 0.0)], follower=follower)
    assert log.finished
    assert log.most_ahead < 0.8
