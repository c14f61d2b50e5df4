"""Paths to segments: what is sent keeps the limits and the path, and ends at rest whatever Ruckig says."""

from __future__ import annotations

import ast
import itertools
import math
from pathlib import Path

import numpy as np
import pytest
import rover.motion
import ruckig
from rover.errors import BadInput
from rover.motion import State
from rover.motion.path.blend import blend_path
from rover.motion.path.clearance import ClearanceMap
from rover.motion.path.limits import DrivingLimits, change_distance
from rover.motion.path.rounding import BlendSettings
from rover.motion.path.speeds import fastest_within, node_speeds
from rover.motion.segment import advance, after, end_state
from rover.motion.trajectory.checked import plan_checked
from rover.motion.trajectory.driven import Driven
from rover.motion.trajectory.plan import plan_segments
from rover.planning.fields import CircleField
from rover.vehicle import Limits, Vehicle

from companion.tests.motion.motion_limits import assert_within_limits

LIMITS = DrivingLimits.of(Vehicle())
ZIGZAG = [(0.0, 0.0), (1.0, 0.0), (1.6, 0.8), (2.6, 0.9), (2.2, 0.4), (1.0, 1.5)]


def random_path(seed: int, count: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    headings = np.cumsum(rng.normal(0.0, 0.9, count - 1))
    steps = rng.uniform(0.05, 1.2, count - 1)[:, None] * np.column_stack([np.cos(headings), np.sin(headings)])
    return np.vstack([np.zeros(2), np.cumsum(steps, axis=0)])


def integrate(trajectory, step=0.002):
    """Positions by small steps: nothing shared with the code under test but the evaluation of one segment."""
    x, y, state = trajectory.x, trajectory.y, State(heading=trajectory.heading)
    points = [(x, y)]
    for segment in trajectory.segments:
        count = max(1, math.ceil(segment.duration_us * 1e-6 / step))
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
    return np.array(points)


@pytest.mark.parametrize("seed", range(12))
def test_segments_keep_every_limit_and_end_where_the_path_ends(seed):
    path = random_path(seed, 12)
    checked = plan_checked(path, LIMITS, BlendSettings(max_cut=0.02 + 0.01 * seed), start_heading=0.3)
    segments = checked.trajectory.segments
    assert_within_limits(segments, State())
    state = State()
    for segment in segments:
        if segment.begin:
            assert state.at_rest
        for t in np.linspace(0.0, segment.duration_us * 1e-6, 12).tolist():
            at = advance(state, segment.jerk_travel * 1e-6, segment.jerk_heading * 1e-6, t)
            assert abs(at.speed * at.turn_rate) <= LIMITS.lateral
            assert at.speed > -1e-5
        state = after(state, segment)
    assert end_state(segments, State()).at_rest
    points = integrate(checked.trajectory)
    assert math.dist(points[-1], path[-1]) < 5e-4
    assert checked.driven.poses[-1, :2] == pytest.approx(points[-1], abs=2e-6)


def test_errors_do_not_add_up_over_three_hundred_rows_of_five_metres():
    rows = np.repeat(np.arange(300) * 0.5, 2)
    path = np.column_stack([np.tile([0.0, 5.0, 5.0, 0.0], 150), rows])
    checked = plan_checked(path, LIMITS)
    assert len(checked.stretches) == 1
    assert math.dist(checked.driven.poses[-1, :2], path[-1]) < 2e-4
    pieces = [piece for stretch in checked.stretches for piece in stretch.pieces]
    begins = checked.driven.poses[checked.trajectory.starts, :2]
    off = np.hypot(*(begins - [(piece.x, piece.y) for piece in pieces]).T)
    assert off.max() < 2e-4
    assert checked.deviation <= BlendSettings().max_cut


def test_extrema_are_those_of_forty_states_a_segment():
    trajectory = plan_segments(blend_path(ZIGZAG, LIMITS).stretches, LIMITS)
    speed = turn_rate = 0.0
    state = State()
    for segment in trajectory.segments:
        for t in np.linspace(0.0, segment.duration_us * 1e-6, 40).tolist():
            at = advance(state, segment.jerk_travel * 1e-6, segment.jerk_heading * 1e-6, t)
            speed, turn_rate = max(speed, abs(at.speed)), max(turn_rate, abs(at.turn_rate))
        state = after(state, segment)
    extrema = Driven(trajectory).extrema
    assert extrema.speed == pytest.approx(speed, rel=1e-6)
    assert extrema.turn_rate == pytest.approx(turn_rate, rel=2e-3)
    assert extrema.turn_rate >= turn_rate - 1e-12
    tight = DrivingLimits(Limits(0.2, 0.5, 3.0), LIMITS.heading)
    assert extrema.broken(LIMITS) == ""
    assert "speed" in extrema.broken(tight)


def test_the_footprint_that_is_swept_stays_in_free_space():
    field = CircleField(4.0, 3.0, [(1.0, 0.4, 0.1), (1.5, 1.6, 0.15), (2.6, 1.2, 0.2)])
    path = [(0.4, 0.6), (1.0, 0.85), (2.0, 0.8), (2.6, 0.7), (3.2, 1.2), (3.2, 2.4)]
    clearance = ClearanceMap.of(field, 0.15)
    checked = plan_checked(path, LIMITS, BlendSettings(max_cut=0.3), clearance)
    assert any(piece.angle for stretch in checked.stretches for piece in stretch.pieces)
    assert field.clearance(integrate(checked.trajectory)).min() >= 0.15


def test_a_path_through_an_obstacle_is_bad_input():
    clearance = ClearanceMap.of(CircleField(4.0, 2.0, [(2.0, 1.0, 0.2)]), 0.15)
    with pytest.raises(BadInput, match="not free near"):
        plan_checked([(0.5, 1.0), (3.5, 1.0)], LIMITS, None, clearance)


def test_rounding_corners_saves_time():
    rounded = plan_checked(ZIGZAG, LIMITS).trajectory.duration
    turned = plan_checked(ZIGZAG, LIMITS, BlendSettings(max_cut=0.0)).trajectory.duration
    assert rounded < 0.9 * turned


@pytest.mark.parametrize("answer", [result for result in ruckig.Result if int(result) < 0])
@pytest.mark.parametrize("calls", [0, 1, 3, 4])
def test_every_negative_result_of_ruckig_becomes_a_controlled_stop(monkeypatch, answer, calls):
    real, count = ruckig.Ruckig, itertools.count()

    class Refusing:
        def __init__(self, degrees_of_freedom):
            self.solver = real(degrees_of_freedom)

        def calculate(self, request, trajectory):
            return answer if next(count) >= calls else self.solver.calculate(request, trajectory)

    monkeypatch.setattr(ruckig, "Ruckig", Refusing)
    trajectory = plan_segments(blend_path(ZIGZAG, LIMITS).stretches, LIMITS, 0.5)
    assert answer.name in trajectory.failure
    assert bool(trajectory.segments) == (calls > 0)
    assert end_state(trajectory.segments, State()).at_rest
    assert_within_limits(trajectory.segments, State())


def test_speeds_at_the_joints_can_be_reached_and_braked_from():
    bounds = LIMITS.travel
    assert change_distance(0.0, 0.25, bounds) == pytest.approx(0.125 * (0.5 + 1 / 6))
    reached = fastest_within(0.05, 0.25, 0.02, bounds)
    assert change_distance(0.05, reached, bounds) == pytest.approx(0.02, rel=1e-4)
    for stretch in blend_path(random_path(8, 40), LIMITS, BlendSettings(max_cut=0.03)).stretches:
        speeds = node_speeds(stretch.pieces, bounds)
        assert speeds[0] == speeds[-1] == 0.0
        for piece, a, b in zip(stretch.pieces, speeds[:-1], speeds[1:], strict=True):
            assert max(a, b) <= piece.speed + 1e-12
            if piece.parts and piece.change is None:
                assert a == b > 0.0
            elif not piece.parts:
                assert change_distance(min(a, b), max(a, b), bounds) <= piece.length


def test_a_leg_longer_than_a_segment_may_last_is_cut():
    assert plan_checked([(0.0, 0.0), (9.0, 0.0)], LIMITS).driven.poses[-1, 0] == pytest.approx(9.0, abs=1e-5)


def test_nothing_in_motion_can_reach_a_network():
    """Ruckig asks a web service for waypoints: solvers have one argument, and no module imports what could connect."""
    allowed = {
        "bisect",
        "cv2",
        "html",
        "collections",
        "dataclasses",
        "functools",
        "itertools",
        "math",
        "numpy",
        "rover",
        "ruckig",
    }
    # The planner in Rust uses no crate but those of PyO3 and numpy.
    allowed |= {"__future__", "numpy", "rover", "rover_native", "ruckig", "typing"}
    for path in sorted(Path(rover.motion.__file__).parent.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                assert {alias.name.split(".")[0] for alias in node.names} <= allowed, path
            if isinstance(node, ast.ImportFrom):
                assert (node.module or "").split(".")[0] in allowed, path
            if isinstance(node, ast.Attribute):
                assert node.attr not in ("intermediate_positions", "filter_intermediate_positions"), path
            if isinstance(node, ast.Call) and ast.unparse(node.func) in ("ruckig.Ruckig", "ruckig.Trajectory"):
                assert [ast.unparse(argument) for argument in node.args] == ["1"], path
                assert not node.keywords, path
