"""The record of what has been sent."""

from __future__ import annotations

import math

import pytest
from rover.geometry import Pose2
from rover.motion import CommittedMotion, State, evaluate
from rover.motion.following.committed import dead_reckon
from rover.motion.merge import merge, run
from rover.motion.profile import Axis, to_position
from rover.motion.segment import Segment
from rover.vehicle import Vehicle


def turn_and_go() -> list[Segment]:
    vehicle = Vehicle()
    return run(merge(to_position(Axis(), 1.0, vehicle.travel), to_position(Axis(), 0.5, vehicle.heading)))


def test_the_state_at_any_time_is_that_of_the_segments():
    committed = CommittedMotion()
    segments = turn_and_go()
    committed.append(segments, 10.0)
    for t in (0.0, 0.3, 1.7, 4.0):
        assert committed.state_at(10.0 + t).travel == pytest.approx(evaluate(segments, State(), t).travel)
    assert committed.state_at(9.0) == State()
    assert committed.state_at(99.0) == committed.end_state
    assert committed.end_state.at_rest


def test_runs_follow_each_other_and_rest_between():
    committed = CommittedMotion()
    committed.append(turn_and_go(), 1.0)
    end = committed.end_time
    committed.append(turn_and_go(), end + 1.0)
    assert committed.state_at(end + 0.5).at_rest
    assert committed.end_state.travel == pytest.approx(2.0, abs=2e-4)
    with pytest.raises(ValueError, match="start time"):
        committed.append(turn_and_go(), committed.end_time - 0.1)
    with pytest.raises(ValueError, match="start time"):
        committed.append(turn_and_go())


def test_increments_move_a_pose_by_what_is_still_to_come():
    committed = CommittedMotion()
    committed.append(turn_and_go(), 0.0)
    whole = dead_reckon(Pose2(0.0, 0.0, 0.0), committed.increments(0.0, committed.end_time))
    first = dead_reckon(Pose2(0.0, 0.0, 0.0), committed.increments(0.0, 1.3))
    rest = dead_reckon(first, committed.increments(1.3, committed.end_time))
    assert rest.x == pytest.approx(whole.x, abs=1e-4)
    assert rest.y == pytest.approx(whole.y, abs=1e-4)
    assert whole.heading == pytest.approx(0.5, abs=1e-4)
    assert committed.increments(committed.end_time, committed.end_time) == []


def test_slip_and_drift_bend_the_prediction():
    steps = [(0.01, 0.0)] * 100
    pose = dead_reckon(Pose2(0.0, 0.0, 0.0), steps, scale=0.9, drift=0.1)
    assert pose.heading == pytest.approx(0.1)
    assert math.hypot(pose.x, pose.y) == pytest.approx(0.9, abs=1e-3)


def test_a_flush_forgets_what_was_to_come():
    committed = CommittedMotion()
    committed.append(turn_and_go(), 0.0)
    at = committed.state_at(1.0)
    committed.truncate(1.0)
    assert committed.end_time == 1.0
    assert committed.end_state == at.rested()
    committed.append(turn_and_go(), 1.5)
    assert committed.end_state.travel == pytest.approx(at.travel + 1.0, abs=2e-4)


def test_old_motion_is_forgotten_and_the_end_kept():
    committed = CommittedMotion()
    for number in range(20):
        committed.append(turn_and_go(), 10.0 * number)
        committed.forget_before(10.0 * number)
    assert len(committed._pieces) < 40
    assert committed.end_state.travel == pytest.approx(20.0, abs=1e-3)
