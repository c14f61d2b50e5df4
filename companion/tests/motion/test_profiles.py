"""Profiles as segments: where Ruckig says, within the limits, and controlled stops from anywhere."""

from __future__ import annotations

import math

import numpy as np
import pytest
import ruckig
from hypothesis import given, settings
from hypothesis import strategies as st
from rover.motion import State, evaluate, stop_segments
from rover.motion.merge import merge, run
from rover.motion.profile import Axis, MotionError, to_position, to_speed
from rover.motion.segment import advance, duration_us, end_state
from rover.vehicle import Limits, Vehicle

from companion.tests.motion.motion_limits import assert_within_limits

TRAVEL, HEADING = Vehicle().travel, Vehicle().heading


@given(st.floats(-3.0, 3.0), st.floats(-math.pi, math.pi))
@settings(max_examples=150, deadline=None)
def test_a_run_from_rest_ends_where_it_was_told_to_a_tenth_of_a_millimetre(distance, angle):
    segments = run(merge(to_position(Axis(), distance, TRAVEL), to_position(Axis(), angle, HEADING)))
    end = end_state(segments, State())
    if segments:
        assert segments[0].begin
        assert segments[-1].rest
        assert end.at_rest
    assert end.travel == pytest.approx(distance, abs=1e-4)
    assert end.heading == pytest.approx(angle, abs=1e-4)
    assert_within_limits(segments, State())


@given(st.floats(-0.25, 0.25), st.floats(-0.4, 0.4), st.floats(-2.0, 2.0), st.integers(0, 1000))
@settings(max_examples=100, deadline=None)
def test_segments_follow_ruckigs_own_evaluation_all_the_way(speed, acceleration, distance, permille):
    request = ruckig.InputParameter(1)
    request.current_position, request.current_velocity, request.current_acceleration = [0.0], [speed], [acceleration]
    request.target_position = [distance]
    request.max_velocity, request.max_acceleration, request.max_jerk = (
        [TRAVEL.speed],
        [TRAVEL.acceleration],
        [TRAVEL.jerk],
    )
    trajectory = ruckig.Trajectory(1)
    assert int(ruckig.Ruckig(1).calculate(request, trajectory)) >= 0
    segments = merge(to_position(Axis(0.0, speed, acceleration), distance, TRAVEL), None)
    t = trajectory.duration * permille / 1000
    expected = trajectory.at_time(t)[0]
    state = evaluate(segments, State(speed=speed, acceleration=acceleration), t)
    assert state.travel == pytest.approx(np.ravel(expected)[0], abs=1e-4)


def test_both_axes_keep_their_own_breakpoints():
    travel, heading = to_position(Axis(), 1.0, TRAVEL), to_position(Axis(), 1.0, HEADING)
    segments = merge(travel, heading)
    assert duration_us(segments) == pytest.approx(max(travel.duration, heading.duration) * 1e6, abs=1.0)
    assert len(segments) <= len(travel.pieces) + len(heading.pieces)
    for profile, name in ((travel, "travel"), (heading, "heading")):
        t = 0.0
        for duration, _ in profile.pieces:
            t += duration
        assert getattr(evaluate(segments, State(), t), name) == pytest.approx(1.0, abs=1e-4)


def test_motion_cut_off_after_a_while_is_the_beginning_of_the_whole():
    profile = to_position(Axis(), 1.0, TRAVEL)
    whole, cut = merge(profile, None), merge(profile, None, until=0.7)
    assert duration_us(cut) == 700_000
    a, b = evaluate(whole, State(), 0.7), end_state(cut, State())
    assert b.travel == pytest.approx(a.travel, abs=1e-5)
    assert b.speed == pytest.approx(a.speed, abs=1e-5)


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_what_ruckig_refuses_is_a_motion_error_in_one_line(bad):
    with pytest.raises(MotionError, match="no motion profile") as caught:
        to_position(Axis(0.0, bad, 0.0), 1.0, TRAVEL)
    assert "\n" not in str(caught.value)
    with pytest.raises(MotionError):
        to_position(Axis(), bad, TRAVEL)
    with pytest.raises(MotionError):
        to_position(Axis(), 1.0, Limits(0.0, 0.5, 3.0))


@given(st.floats(-0.3, 0.3), st.floats(-0.6, 0.6), st.floats(-1.3, 1.3), st.floats(-3.5, 3.5))
@settings(max_examples=200, deadline=None)
def test_a_stop_from_anywhere_comes_to_rest_as_fast_as_ruckigs(speed, acceleration, rate, turn_acceleration):
    state = State(0.0, speed, acceleration, 0.0, rate, turn_acceleration)
    segments = stop_segments(state, TRAVEL, HEADING)
    assert segments[-1].rest
    assert all(not segment.rest for segment in segments[:-1])
    # The rest flag only takes away what quantisation left.
    before = state
    for segment in segments:
        before = advance(before, segment.jerk_travel * 1e-6, segment.jerk_heading * 1e-6, segment.duration_us * 1e-6)
    assert abs(before.speed) < 2e-5
    assert abs(before.turn_rate) < 1e-4
    fastest = max(
        to_speed(Axis(0.0, speed, acceleration), 0.0, TRAVEL).duration,
        to_speed(Axis(0.0, rate, turn_acceleration), 0.0, HEADING).duration,
    )
    assert duration_us(segments) * 1e-6 <= fastest + 0.003
    for segment in segments:
        assert abs(segment.jerk_travel) <= TRAVEL.jerk * 1.001e6
        assert abs(segment.jerk_heading) <= HEADING.jerk * 1.001e6


@pytest.mark.parametrize("answer", [result for result in ruckig.Result if int(result) < 0])
def test_every_negative_result_of_ruckig_is_a_motion_error(monkeypatch, answer):
    class Refusing:
        def __init__(self, degrees_of_freedom):
            assert degrees_of_freedom == 1

        def calculate(self, request, trajectory):
            return answer

    monkeypatch.setattr(ruckig, "Ruckig", Refusing)
    with pytest.raises(MotionError, match=answer.name):
        to_position(Axis(), 1.0, TRAVEL)
    with pytest.raises(MotionError, match=answer.name):
        to_speed(Axis(0.0, 0.2, 0.0), 0.0, TRAVEL)
