"""Room at the corners of a shortest path: one wide corner for many small ones, and only where the footprint may go."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from rover.geometry import Pose2
from rover.motion.path.blend import blend_path
from rover.motion.path.clearance import ClearanceMap
from rover.motion.path.limits import DrivingLimits
from rover.motion.path.rounding import BlendSettings
from rover.motion.path.widen import widened
from rover.motion.trajectory.checked import plan_checked
from rover.planning.fields import CircleField
from rover.planning.planner import plan
from rover.vehicle import Vehicle

from companion.tests.motion.motion_simulation import drive

RADIUS = 0.15
POST = (1.0, 1.0, 0.2)


def around_the_post(corners: int) -> list[tuple[float, float]]:
    """A taut way around the post: tangents, and corners just outside of where the rover's disc touches it."""
    angles = np.radians(np.linspace(130.0, 50.0, corners))
    reach = (RADIUS + POST[2] + 1e-4) / math.cos(math.radians(40.0 / max(corners - 1, 1)))
    arc = [(1.0 + reach * math.cos(a), 1.0 + reach * math.sin(a)) for a in angles.tolist()]
    (x0, y0), (x1, y1) = arc[0], arc[-1]
    slope = math.radians(35.0)
    first = (x0 - 0.6 * math.cos(slope), y0 - 0.6 * math.sin(slope))
    return [first, *arc, (x1 + 0.6 * math.cos(slope), y1 - 0.6 * math.sin(slope))]


def test_a_row_of_small_corners_becomes_one_that_can_be_rounded():
    field = CircleField(3.0, 3.0, [POST])
    clearance, path = ClearanceMap.of(field, RADIUS), around_the_post(6)
    wide, _ = widened(path, clearance, 0.2)
    assert len(wide) == 3
    assert wide[0] == path[0]
    assert wide[-1] == path[-1]
    limits = DrivingLimits.of(Vehicle())
    slowest = []
    for line in (path, wide):
        (stretch,) = blend_path(line, limits, BlendSettings(max_cut=0.3), clearance).stretches
        slowest.append(min(piece.speed for piece in stretch.pieces))
    assert slowest[1] > 1.2 * slowest[0]


def test_a_corner_with_room_beside_it_stays_where_it_is():
    path = [(0.5, 0.5), (1.5, 0.5), (2.0, 1.5)]
    wide, off = widened(path, ClearanceMap.of(CircleField(3.0, 3.0, []), RADIUS), 0.06)
    assert wide == path
    assert off.tolist() == [0.0, 0.0]


def tour(seed):
    """A field of circles and a shortest path between two places in it; None where none are free or joined."""
    rng = np.random.default_rng(seed)
    circles = np.column_stack([rng.uniform(0.3, 3.7, (14, 2)), rng.uniform(0.08, 0.25, 14)])
    field = CircleField(4.0, 4.0, circles.tolist())
    free = rng.uniform(0.2, 3.8, (40, 2))
    free = free[field.clearance(free) > RADIUS + 0.02]
    found = plan(field, tuple(free[0]), [tuple(free[1])], robot_radius=RADIUS, seed=seed)
    return (field, found.path) if found.ok and len(found.path) > 2 else None


def beside(places, path):
    """(N,): distance of each place from the polyline."""
    best = np.full(len(places), np.inf)
    for a, b in itertools.pairwise(np.asarray(path)):
        along = b - a
        share = np.clip((places - a) @ along / max(along @ along, 1e-18), 0.0, 1.0)
        best = np.minimum(best, np.hypot(*(places - a - share[:, None] * along).T))
    return best


def test_no_corner_is_moved_further_than_allowed_nor_where_the_footprint_may_not_go():
    checked = 0
    for field, path in filter(None, map(tour, range(40))):
        wide, off = widened(path.tolist(), ClearanceMap.of(field, RADIUS), 0.06)
        checked += 1
        for corner in np.array(wide)[1:-1]:
            assert np.hypot(*(path - corner).T).min() <= 2 * 0.06 + 1e-9
        for (a, b), said in zip(itertools.pairwise(wide), off, strict=True):
            assert field.segment_clear(a, b, RADIUS - 2e-5)
            assert beside(np.linspace(a, b, 400), path).max() <= said + 1e-9
    assert checked > 10


def test_a_row_of_corners_made_one_is_said_to_be_as_far_beside_them_as_it_is():
    """One corner for many, then moved outward: further than it may be moved at once."""
    path = np.array(around_the_post(6))
    wide, off = widened(path.tolist(), ClearanceMap.of(CircleField(3.0, 3.0, [POST]), RADIUS), 0.06)
    far = [beside(np.linspace(a, b, 2000), path).max() for a, b in itertools.pairwise(wide)]
    assert max(far) > 0.065
    assert (off >= far).all()
    assert off == pytest.approx(far, abs=1.5e-3)


@given(st.integers(0, 100_000))
@settings(max_examples=12, deadline=None)
def test_the_rover_is_beside_a_widened_path_by_no_more_than_is_said(seed):
    drawn = tour(seed)
    assume(drawn is not None)
    field, path = drawn
    blend = BlendSettings(max_cut=0.3, widen=0.06)
    checked = plan_checked(path, DrivingLimits.of(Vehicle()), blend, ClearanceMap.of(field, RADIUS))
    assert beside(checked.driven.points, path).max() <= checked.deviation + 1e-4


@pytest.mark.parametrize("most", [0.0, 1e-3, 0.3])
def test_where_nothing_is_free_beside_the_path_it_stays_as_it_is(most):
    path = around_the_post(4)
    wide, off = widened(path, ClearanceMap(lambda points: np.full(len(points), -1.0)), most)
    assert wide == path
    assert not off.any()


def test_the_rover_is_round_a_post_in_less_than_two_thirds_of_the_time():
    path, start = around_the_post(6), Pose2(*around_the_post(6)[0], math.radians(35.0))
    clearance = ClearanceMap.of(CircleField(3.0, 3.0, [POST]), RADIUS)
    rounded = drive(path, start=start, wheels=(0.97, 0.95), noise=(0.004, 0.006), clearance=clearance)[2]
    turned = drive(path, start=start, wheels=(0.97, 0.95), noise=(0.004, 0.006))[2]
    assert rounded.finished
    assert rounded.times[-1] < 0.67 * turned.times[-1]
