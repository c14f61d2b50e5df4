"""Paths as they come from outside, dense, jagged or long, are driven at the pace of their shape."""

from __future__ import annotations

import itertools
import json
import math
import os
import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rover.motion.path.clearance import ClearanceMap
from rover.motion.path.condition import simplified
from rover.motion.path.limits import DrivingLimits
from rover.motion.path.rounding import BlendSettings
from rover.motion.segment import State, advance, after
from rover.motion.trajectory.checked import plan_checked
from rover.planning.fields import CircleField
from rover.vehicle import Vehicle

LIMITS = DrivingLimits.of(Vehicle())
# Seconds that starting and stopping take more than driving on at full speed.
RAMPS = 0.25 / 0.5 + 0.5 / 3.0


def circle(radius, step, turns=1.0):
    angle = np.linspace(0.0, 2.0 * math.pi * turns, max(4, round(2.0 * math.pi * radius * turns / step)) + 1)
    return radius * np.column_stack([np.sin(angle), 1.0 - np.cos(angle)])


def exceeded(segments):
    """Names of limits that are exceeded in any of 30 states of a segment, by nothing but its own evaluation."""
    found, state = set(), State()
    for segment in segments:
        jerk, turn_jerk = segment.jerk_travel * 1e-6, segment.jerk_heading * 1e-6
        for t in np.linspace(0.0, segment.duration_us * 1e-6, 30).tolist():
            at = advance(state, jerk, turn_jerk, t)
            for name, value, bound in (
                ("speed", at.speed, LIMITS.travel.speed),
                ("acceleration", at.acceleration, LIMITS.travel.acceleration),
                ("jerk", jerk, LIMITS.travel.jerk),
                ("turn rate", at.turn_rate, LIMITS.heading.speed),
                ("turn acceleration", at.turn_acceleration, LIMITS.heading.acceleration),
                ("turn jerk", turn_jerk, LIMITS.heading.jerk),
                ("lateral", at.speed * at.turn_rate, LIMITS.lateral),
            ):
                if abs(value) > bound:
                    found.add(name)
        state = after(state, segment)
    return found if state.at_rest else found | {"rest"}


def beside(checked, path):
    """Largest distance of the driven path from the polyline, metres."""
    x, y, state, points = checked.trajectory.x, checked.trajectory.y, State(heading=checked.trajectory.heading), []
    for segment in checked.trajectory.segments:
        count = max(1, math.ceil(segment.duration_us / 10_000))
        before = state
        for number in range(1, count + 1):
            t = segment.duration_us * 1e-6 * number / count
            now = advance(state, segment.jerk_travel * 1e-6, segment.jerk_heading * 1e-6, t)
            middle = 0.5 * (now.heading + before.heading)
            x += (now.travel - before.travel) * math.cos(middle)
            y += (now.travel - before.travel) * math.sin(middle)
            points.append((x, y))
            before = now
        state = after(state, segment)
    best = np.full(len(points), np.inf)
    for a, b in itertools.pairwise(path):
        along = b - a
        share = np.clip((np.array(points) - a) @ along / max(along @ along, 1e-18), 0.0, 1.0)
        best = np.minimum(best, np.hypot(*(np.array(points) - a - share[:, None] * along).T))
    return float(best.max())


@pytest.mark.parametrize("step", [0.0005, 0.006, 0.0175, 0.05])
def test_a_circle_of_a_metre_takes_the_time_of_its_shape_whatever_the_sampling(step):
    checked = plan_checked(circle(1.0, step), LIMITS)
    assert checked.trajectory.duration < 1.05 * (2.0 * math.pi / 0.25 + RAMPS)
    assert len(checked.stretches) == 1
    assert checked.deviation < 0.01
    assert exceeded(checked.trajectory.segments) == set()


@pytest.mark.parametrize("step", [0.0001, 0.001, 0.01, 0.03])
def test_a_line_takes_the_time_of_its_shape_whatever_the_sampling(step):
    path = np.column_stack([np.arange(0.0, 2.0 + step / 2.0, step), np.zeros(round(2.0 / step) + 1)])
    assert plan_checked(path, LIMITS).trajectory.duration == pytest.approx(2.0 / 0.25 + RAMPS, rel=0.01)


def test_steps_of_a_centimetre_are_driven_along_the_line_that_they_stand_for():
    number = np.arange(401)
    path = 0.01 * np.column_stack([(number + 1) // 2, number // 2])
    checked = plan_checked(path, LIMITS)
    assert checked.trajectory.duration < 1.05 * (2.0 * math.sqrt(2.0) / 0.25 + RAMPS)
    assert beside(checked, path) < 0.02


def test_a_walk_of_three_hundred_corners_does_not_stop_at_all_of_them_for_the_sake_of_one():
    rng = np.random.default_rng(20)
    headings = np.cumsum(rng.normal(0.0, 0.6, 300))
    steps = rng.uniform(0.2, 0.4, 300)[:, None] * np.column_stack([np.cos(headings), np.sin(headings)])
    path = np.vstack([np.zeros(2), np.cumsum(steps, axis=0)])
    checked = plan_checked(path, LIMITS)
    length = sum(stretch.length for stretch in checked.stretches)
    assert len(checked.stretches) < 5
    assert checked.trajectory.duration < 1.4 * length / 0.25
    assert exceeded(checked.trajectory.segments) == set()


def sine(step, noise=0.0):
    x = np.arange(0.0, 9.0, step)
    return np.column_stack([x, 0.6 * np.sin(2.0 * math.pi * x / 3.0)]) + noise * np.random.default_rng(31).normal(
        size=(len(x), 2)
    )


def spiral(step, turns=4, pitch=0.25):
    angle = 2.0 * math.pi * np.sqrt(np.linspace(0.05, turns**2, int(math.pi * turns**2 * pitch / step)))
    return (0.3 + pitch * angle / (2.0 * math.pi))[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])


def mower(rows, length, gap):
    ends = np.tile([0.0, length, length, 0.0], rows // 2)
    return np.column_stack([ends, gap * np.repeat(np.arange(rows), 2)])


def grid_stairs(cell, run):
    number = np.arange(300)
    return cell * np.column_stack([run * ((number + 1) // 2), number // 2])


@pytest.mark.parametrize(
    ("path", "most"),
    [
        *((sine(step), 1.05) for step in (0.0005, 0.004, 0.02, 0.05)),
        (sine(0.03, 0.003), 1.05),
        *((spiral(step), 1.05) for step in (0.002, 0.01, 0.04)),
        *((grid_stairs(cell, run), 1.05) for cell in (0.005, 0.02, 0.05) for run in (1, 2)),
        *((grid_stairs(0.04 / (1 + run) * share, run), 1.05) for run in (1, 2, 3) for share in (0.99, 1.0, 2.0)),
        (mower(60, 6.3, 0.45), 1.15),
        (mower(40, 3.0, 0.3), 1.3),
    ],
)
def test_a_shape_is_driven_at_its_own_pace_without_a_stop(path, most):
    checked = plan_checked(path, LIMITS)
    length = sum(stretch.length for stretch in checked.stretches)
    assert len(checked.stretches) == 1
    assert length <= np.hypot(*np.diff(path, axis=0).T).sum() * 1.001
    assert checked.trajectory.duration <= most * (length / 0.25 + RAMPS)
    assert exceeded(checked.trajectory.segments) == set()


def test_three_hundred_rows_of_a_mower_are_no_worse_than_thirty():
    """Errors of the segments' integers do not add up over 2 km, and processor time grows as the points do."""
    pace, seconds = [], []
    for rows in (30, 300):
        began = time.process_time()
        checked = plan_checked(mower(rows, 6.3, 0.45), LIMITS)
        seconds.append(time.process_time() - began)
        pace.append(checked.trajectory.duration / sum(stretch.length for stretch in checked.stretches))
        assert len(checked.stretches) == 1
        assert checked.deviation <= 0.0501
    assert pace[1] < 1.02 * pace[0]
    assert seconds[1] < 20.0 * seconds[0] + 0.2


@given(st.integers(0, 100_000), st.floats(0.02, 0.3), st.floats(0.01, 0.15))
@settings(max_examples=25, deadline=None)
def test_any_walk_is_driven_within_limits_and_tolerance_to_its_end(seed, leg, tolerance):
    rng = np.random.default_rng(seed)
    headings = np.cumsum(rng.normal(0.0, 0.9, 20))
    steps = rng.uniform(0.3, 1.0, 20)[:, None] * leg * np.column_stack([np.cos(headings), np.sin(headings)])
    path = np.vstack([np.zeros(2), np.cumsum(steps, axis=0)])
    checked = plan_checked(path, LIMITS, BlendSettings(max_cut=tolerance))
    assert not checked.trajectory.failure
    assert exceeded(checked.trajectory.segments) == set()
    assert checked.deviation <= tolerance + 1e-4
    assert beside(checked, path) <= checked.deviation + 1e-4
    assert math.dist(checked.driven.poses[-1, :2], path[-1]) < 0.25 * tolerance + 1e-3


@given(st.integers(0, 100_000))
@settings(max_examples=15, deadline=None)
def test_a_dense_path_beside_obstacles_never_touches_them(seed):
    rng = np.random.default_rng(seed)
    path = np.array([2.0, 1.0]) + circle(1.0, 0.03)
    angle = rng.uniform(0.0, 2.0 * math.pi, 6)
    radius = rng.choice([1.0 - 0.27, 1.0 + 0.27], 6)
    posts = [(2.0 + r * math.sin(a), 2.0 - r * math.cos(a), 0.1) for a, r in zip(angle, radius, strict=True)]
    field = CircleField(4.0, 4.0, posts)
    checked = plan_checked(path, LIMITS, BlendSettings(max_cut=0.3), ClearanceMap.of(field, 0.15))
    assert field.clearance(checked.driven.points).min() >= 0.15 - 2e-5


@given(st.integers(0, 100_000), st.floats(0.0005, 0.05))
@settings(max_examples=40, deadline=None)
def test_points_that_are_left_out_are_as_near_as_is_said(seed, tolerance):
    rng = np.random.default_rng(seed)
    points = np.cumsum(rng.normal(0.0, 0.02, (80, 2)), axis=0)
    kept, error = simplified(points, tolerance)
    assert error.max() <= 1.01 * tolerance
    assert kept[0].tolist() == points[0].tolist()
    assert kept[-1].tolist() == points[-1].tolist()
    best = np.full(len(points), np.inf)
    for a, b in itertools.pairwise(kept):
        along = b - a
        share = np.clip((points - a) @ along / max(along @ along, 1e-18), 0.0, 1.0)
        best = np.minimum(best, np.hypot(*(points - a - share[:, None] * along).T))
    assert best.max() <= error.max() + 1e-9


SHARED = Path(os.environ.get("ROVER_DATA", "")) / "cases" / "30_dense_paths"


@pytest.mark.skipif(not SHARED.is_dir(), reason="ROVER_DATA does not lead to cases/30_dense_paths")
@pytest.mark.parametrize(
    ("name", "most"),
    [
        ("circle_1deg", 1.05),
        ("circle6mm", 1.05),
        ("stairs1cm", 1.05),
        ("straight_1cm", 1.01),
        ("dense01mm", 1.01),
        ("lawnmower_100x5m", 1.15),
        ("walk250", 1.2),
        ("walk300", 1.2),
    ],
)
def test_shared_cases_are_driven_at_the_pace_of_their_shape(name, most):
    data = json.loads((SHARED / f"{name}.json").read_text())
    checked = plan_checked(data["path"] if isinstance(data, dict) else data, LIMITS)
    length = sum(stretch.length for stretch in checked.stretches)
    assert checked.trajectory.duration <= most * (length / 0.25 + RAMPS)
    assert exceeded(checked.trajectory.segments) == set()


@pytest.mark.parametrize("seed", range(4))
def test_a_slow_place_in_a_trembling_track_is_crept_through_and_makes_no_row_of_stops(seed):
    """A wave of tight turns with a tremor of some millimetres, sampled unevenly: one place slower than the lowest speed
    used to cut the bend there, which left the next too little room, and so on."""
    rng = np.random.default_rng([71, seed])
    x = np.sort(rng.uniform(0.0, 4.0, 220))
    track = np.column_stack([x, 0.25 * np.sin(2.0 * math.pi * x / 0.55)]) + rng.normal(0.0, 0.003, (220, 2))
    checked = plan_checked(track, LIMITS)
    assert len(checked.stretches) == 1
    length = np.hypot(*np.diff(track, axis=0).T).sum()
    assert checked.trajectory.duration < 2.3 * length / 0.25
