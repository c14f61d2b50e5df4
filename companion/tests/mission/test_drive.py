"""Driving one stretch: what of the path still lies ahead, and what the rover does when it is blocked."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rover.geometry import Pose2
from rover.mission.config import Area, Launch
from rover.mission.drive import COMMITTED_REACH, START_LEAD, Drive, cut, remaining
from rover.mission.freespace import FreeSpace, free_space
from rover.motion.segment import Segment
from rover.vehicle import Vehicle

CORNER = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 2.0]])
CYCLE = 0.02


def ground(*obstacles: tuple[float, float, float]) -> FreeSpace:
    """3 x 3 m, all seen, with these obstacles."""
    seen = np.ones((150, 150), bool)
    launch = Launch(Pose2(0.5, 0.5, 0.0), 0.25)
    return free_space(~seen, seen, 0.02, (), Area(3.0, 3.0, obstacles), launch, Vehicle())


def length(path: np.ndarray) -> float:
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())


@pytest.mark.parametrize(
    ("x", "y", "left"),
    [
        (-0.2, 0.1, [[0.0, 0.0], [1.0, 0.0], [1.0, 2.0]]),
        (0.4, 0.05, [[0.4, 0.0], [1.0, 0.0], [1.0, 2.0]]),
        (1.1, 0.5, [[1.0, 0.5], [1.0, 2.0]]),
        (0.9, 2.5, [[1.0, 2.0], [1.0, 2.0]]),
    ],
)
def test_what_remains_begins_at_the_point_of_the_path_nearest_to_the_rover(
    x: float, y: float, left: list[list[float]]
) -> None:
    np.testing.assert_allclose(remaining(CORNER, Pose2(x, y, 0.0)), left, atol=1e-12)


def test_a_path_with_a_point_twice_has_a_remainder_too() -> None:
    path = np.array([[0.0, 0.0], [0.0, 0.0], [1.0, 0.0]])
    np.testing.assert_allclose(remaining(path, Pose2(0.5, 0.1, 0.0)), [[0.5, 0.0], [1.0, 0.0]])


@pytest.mark.parametrize(
    ("reach", "piece"),
    [
        (0.25, [[0.0, 0.0], [0.25, 0.0]]),
        (1.0, [[0.0, 0.0], [1.0, 0.0]]),
        (1.5, [[0.0, 0.0], [1.0, 0.0], [1.0, 0.5]]),
        (3.0, CORNER.tolist()),
        (9.0, CORNER.tolist()),
    ],
)
def test_a_cut_keeps_the_first_metres(reach: float, piece: list[list[float]]) -> None:
    kept = cut(CORNER, reach)
    assert length(kept) == pytest.approx(min(reach, 3.0))
    np.testing.assert_allclose(kept[: len(piece)], piece, atol=1e-12)


@settings(max_examples=100, deadline=None)
@given(
    st.lists(st.tuples(st.floats(0, 3), st.floats(0, 3)), min_size=2, max_size=8),
    st.floats(0.001, 10),
    st.floats(0, 3),
    st.floats(0, 3),
)
def test_cut_and_remainder_are_never_longer_than_the_path(
    points: list[tuple[float, float]], reach: float, x: float, y: float
) -> None:
    path = np.array(points)
    ahead = remaining(path, Pose2(x, y, 0.0))
    assert length(ahead) <= length(path) + 1e-9
    assert length(cut(ahead, reach)) == pytest.approx(min(reach, length(ahead)), abs=1e-9)
    np.testing.assert_array_equal(ahead[-1], path[-1])


def driving(drive: Drive, seconds: float, start: Pose2) -> float:
    """Steps a drive with a rover that follows exactly, straight along x; returns the time then."""
    now = 1.0
    while now < 1.0 + seconds:
        travelled = drive.committed.state_at(now).travel if drive.committed.end_time > 0.0 else 0.0
        drive.step(now, Pose2(start.x + travelled, start.y, start.heading))
        now += CYCLE
    return now


def test_a_run_starts_late_enough_for_the_wire_to_carry_it() -> None:
    drive = Drive(Vehicle(), 0.25)
    drive.start(np.array([[0.5, 0.5], [2.5, 0.5]]), None)
    segments, start = drive.step(1.0, Pose2(0.5, 0.5, 0.0))
    assert segments[0].begin
    assert start == pytest.approx(1.0 + START_LEAD)
    assert not drive.at_rest(1.0)


def test_a_way_that_stays_free_is_driven_on() -> None:
    drive = Drive(Vehicle(), 0.25)
    drive.start(np.array([[0.5, 0.5], [2.5, 0.5]]), None)
    assert not drive.check(ground(), Pose2(0.7, 0.5, 0.0))
    assert not drive.check(ground((0.3, 1.5, 0.2)), Pose2(0.7, 0.5, 0.0))
    assert not drive.blocked


def test_an_obstacle_behind_the_rover_does_not_stop_it() -> None:
    drive = Drive(Vehicle(), 0.25)
    drive.start(np.array([[0.5, 0.5], [2.5, 0.5]]), None)
    assert not drive.check(ground((0.5, 0.5, 0.05)), Pose2(1.5, 0.5, 0.0))
    assert not drive.blocked


def test_an_obstacle_far_ahead_brakes_and_one_within_what_is_committed_needs_the_firmware() -> None:
    here = Pose2(0.5, 0.5, 0.0)
    for distance, urgent in ((2.0 * COMMITTED_REACH + 0.5, False), (COMMITTED_REACH, True)):
        drive = Drive(Vehicle(), 0.25)
        drive.start(np.array([[0.5, 0.5], [2.5, 0.5]]), None)
        assert drive.check(ground((0.5 + distance, 0.5, 0.1)), here) is urgent
        assert drive.blocked


def test_a_blocked_drive_comes_to_rest_before_the_end_of_its_path() -> None:
    drive = Drive(Vehicle(), 0.25)
    drive.start(np.array([[0.5, 0.5], [2.5, 0.5]]), None)
    start = Pose2(0.5, 0.5, 0.0)
    now = driving(drive, 2.0, start)
    here = drive.committed.state_at(now).travel
    assert 0.1 < here < 0.5
    drive.check(ground((2.2, 0.5, 0.1)), Pose2(0.5 + here, 0.5, 0.0))
    while not drive.at_rest(now) and now < 20.0:
        travelled = drive.committed.state_at(now).travel
        drive.step(now, Pose2(0.5 + travelled, 0.5, 0.0))
        now += CYCLE
    stopped = drive.committed.end_state
    assert stopped.speed == pytest.approx(0.0, abs=1e-3)
    assert stopped.travel - here <= COMMITTED_REACH


def test_a_stop_by_the_firmware_throws_away_what_was_committed() -> None:
    drive = Drive(Vehicle(), 0.25)
    drive.start(np.array([[0.5, 0.5], [2.5, 0.5]]), None)
    now = driving(drive, 1.5, Pose2(0.5, 0.5, 0.0))
    assert drive.committed.end_time > now
    drive.halted(now)
    assert drive.committed.end_time <= now
    assert drive.at_rest(now)
    assert drive.step(now + CYCLE, Pose2(0.7, 0.5, 0.0)) == ([], None)


def test_a_turn_on_the_spot_has_a_path_that_nothing_blocks_and_drives_no_way() -> None:
    drive = Drive(Vehicle(), 0.25)
    drive.turn(Pose2(1.0, 1.0, 0.0), math.pi / 2)
    assert not drive.check(ground((1.0, 1.0, 0.3)), Pose2(1.0, 1.0, 0.0))
    segments, _ = drive.step(1.0, Pose2(1.0, 1.0, 0.0))
    assert segments
    assert all(segment.jerk_travel == 0 for segment in segments)


def test_a_path_whose_ground_has_moved_in_map_is_driven_as_if_nothing_had_happened() -> None:
    """Every segment is the same as without the move: the wheels feel nothing of it."""
    shift = Pose2(0.12, -0.07, 0.05)
    sent: list[list[Segment]] = []
    for moves in (False, True):
        drive, pose = Drive(Vehicle(), 0.25), Pose2(0.5, 0.5, 0.0)
        made: list[Segment] = []
        drive.start(np.array([[0.5, 0.5], [2.0, 0.5]]), 0.0, space=ground())
        frame = Pose2(0.0, 0.0, 0.0)
        for step in range(200):
            now = step * CYCLE
            if moves and step == 100:
                drive.move(shift)
                frame = shift
            segments, _ = drive.step(now, frame.compose(pose))
            made += segments
            for travel, turn in drive.committed.increments(now, now + CYCLE):
                pose = pose.compose(Pose2(travel, 0.0, turn))
        sent.append(made)
        np.testing.assert_allclose(drive.path[-1], frame.transform(np.array([[2.0, 0.5]]))[0], atol=1e-6)
    assert len(sent[0]) == len(sent[1]) > 5
    for one, other in zip(*sent, strict=True):
        assert abs(one.jerk_travel - other.jerk_travel) <= 1
        assert abs(one.jerk_heading - other.jerk_heading) <= 1
