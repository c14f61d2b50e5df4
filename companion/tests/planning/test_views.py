"""Where to stand and look: gains that are true, occlusion, reachability, and poses to inspect a mine from."""

from __future__ import annotations

import math
import time

import numpy as np
import pytest
from rover.errors import BadInput
from rover.geometry import Pose2
from rover.planning import ViewpointSettings, distance_field, inspection_poses, viewpoints

RESOLUTION = 0.02
FOOTPRINT = np.array([[0.16, -0.25], [1.1, -0.6], [1.1, 0.6], [0.16, 0.25]])
SHAPE = (200, 150)


def inside_footprint(pose: Pose2) -> np.ndarray:
    """Cells whose centre lies in the footprint seen from `pose`: half-plane tests, written apart."""
    rows, columns = np.indices(SHAPE)
    points = np.stack([(columns + 0.5) * RESOLUTION, (rows + 0.5) * RESOLUTION], axis=-1).reshape(-1, 2)
    local = pose.inverse().transform(points)
    inside = np.ones(len(local), dtype=bool)
    for a, b in zip(FOOTPRINT, np.roll(FOOTPRINT, -1, axis=0), strict=True):
        edge = b - a
        inside &= edge[0] * (local[:, 1] - a[1]) - edge[1] * (local[:, 0] - a[0]) >= -1e-9
    return inside.reshape(SHAPE)


@pytest.fixture
def survey():
    """A field of 3 × 4 m with the lower left seen."""
    seen = np.zeros(SHAPE, dtype=bool)
    seen[:70, :70] = True
    free = np.zeros(SHAPE, dtype=bool)
    free[8:62, 8:62] = True
    return seen, free, np.ones(SHAPE, dtype=bool)


def test_gains_are_the_unseen_area_in_the_footprint(survey):
    seen, free, area = survey
    pose = Pose2(0.4, 0.4, 0.0)
    distance = distance_field(free, (0.4, 0.4), RESOLUTION)
    views = viewpoints(seen, free, area, FOOTPRINT, pose, RESOLUTION, distance)
    assert len(views) == ViewpointSettings().count
    for view in views:
        expected = (inside_footprint(view.pose) & ~seen).sum() * RESOLUTION**2
        assert view.gain_m2 == pytest.approx(expected, rel=0.03, abs=0.002)
        assert free[int(view.pose.y / RESOLUTION), int(view.pose.x / RESOLUTION)]


def test_nothing_unseen_or_nothing_reachable_gives_no_view(survey):
    seen, free, area = survey
    distance = distance_field(free, (0.4, 0.4), RESOLUTION)
    pose = Pose2(0.4, 0.4, 0.0)
    assert viewpoints(np.ones(SHAPE, bool), free, area, FOOTPRINT, pose, RESOLUTION, distance) == []
    nowhere = np.full(SHAPE, np.inf, dtype=np.float32)
    assert viewpoints(seen, free, area, FOOTPRINT, pose, RESOLUTION, nowhere) == []


def test_a_last_small_unseen_spot_is_still_found():
    seen = np.ones(SHAPE, dtype=bool)
    seen[150:153, 100:103] = False
    free = np.ones(SHAPE, dtype=bool)
    free[:8] = free[-8:] = free[:, :8] = free[:, -8:] = False
    distance = distance_field(free, (0.5, 0.5), RESOLUTION)
    views = viewpoints(seen, free, np.ones(SHAPE, bool), FOOTPRINT, Pose2(0.5, 0.5, 0.0), RESOLUTION, distance)
    assert views
    assert views[0].gain_m2 == pytest.approx(9 * RESOLUTION**2)


def test_ground_behind_a_blocked_cell_does_not_count(survey):
    seen, free, area = survey
    occluders = np.zeros(SHAPE, dtype=bool)
    occluders[30:60, 72] = True  # a wall just outside the seen ground, to the right
    pose = Pose2(0.4, 0.4, 0.0)
    distance = distance_field(free, (0.4, 0.4), RESOLUTION)
    settings = ViewpointSettings(headings=4, count=300)
    open_views = viewpoints(seen, free, area, FOOTPRINT, pose, RESOLUTION, distance, settings)
    hidden = viewpoints(seen, free, area, FOOTPRINT, pose, RESOLUTION, distance, settings, occluders=occluders)
    best = {(v.pose.x, v.pose.y): v.gain_m2 for v in open_views if v.pose.heading == 0.0}
    looking_at_the_wall = [v for v in hidden if v.pose.heading == 0.0 and 0.7 < v.pose.y < 1.1]
    for view in looking_at_the_wall:
        assert view.gain_m2 < 0.8 * best[(view.pose.x, view.pose.y)]
    assert {(v.pose.x, v.pose.y) for v in hidden} <= {(v.pose.x, v.pose.y) for v in open_views}


def test_the_list_is_repeatable_and_quick(survey):
    seen, _, area = survey
    free = np.ones(SHAPE, dtype=bool)
    occluders = np.zeros(SHAPE, dtype=bool)
    occluders[100:110, 60:70] = occluders[50:60, 90:100] = True
    distance = distance_field(free, (0.4, 0.4), RESOLUTION)
    arguments = (seen, free, area, FOOTPRINT, Pose2(0.4, 0.4, 0.0), RESOLUTION, distance)
    first = viewpoints(*arguments, occluders=occluders)
    took = []
    for _ in range(5):
        began = time.thread_time()
        again = viewpoints(*arguments, occluders=occluders)
        took.append(time.thread_time() - began)
        assert first == again
    assert min(took) < 0.03  # processor time; 5 ms on the desk


def test_the_distance_field_goes_around_walls_and_cuts_no_corners():
    free = np.ones((40, 40), dtype=bool)
    free[20, :30] = False
    distance = distance_field(free, (0.1, 0.1), RESOLUTION)
    assert distance[5, 5] == 0.0
    assert np.isinf(distance[20, :30]).all()
    straight = 0.02 * 30
    assert distance[35, 5] > 2.0 * straight
    assert distance[5, 25] == pytest.approx(0.4)


def test_a_start_just_off_free_ground_snaps_to_it_when_asked():
    free = np.zeros((50, 50), dtype=bool)
    free[20:, 20:] = True
    assert np.isinf(distance_field(free, (0.37, 0.9), RESOLUTION)).sum() < free.size  # free from its own cell
    snapped = distance_field(free, (0.35, 0.9), RESOLUTION, snap=0.1)
    assert np.isfinite(snapped[30, 30])
    lost = distance_field(free, (0.05, 0.05), RESOLUTION, snap=0.1)
    assert not np.isfinite(lost[30, 30])


def test_a_start_off_the_grid_is_bad_input():
    with pytest.raises(BadInput, match="outside the grid"):
        distance_field(np.ones((5, 5), dtype=bool), (-0.1, 0.0), RESOLUTION)


def test_inspection_poses_face_the_place_from_reachable_ground_nearest_first(survey):
    _, free, _ = survey
    distance = distance_field(free, (0.3, 0.3), RESOLUTION)
    poses = inspection_poses((1.0, 1.0), free, RESOLUTION, distance)
    assert poses
    for pose in poses:
        ahead = Pose2(1.0, 1.0, 0.0).relative_to(pose)
        assert ahead.y == pytest.approx(0.0, abs=1e-9)
        assert 0.35 - 1e-9 <= ahead.x <= 0.9 + 1e-9
        assert free[int(pose.y / RESOLUTION), int(pose.x / RESOLUTION)]
    travel = [distance[int(p.y / RESOLUTION), int(p.x / RESOLUTION)] for p in poses]
    assert travel == sorted(travel)


def test_a_place_out_of_reach_or_out_of_sight_has_no_inspection_pose(survey):
    _, free, _ = survey
    distance = distance_field(free, (0.3, 0.3), RESOLUTION)
    assert inspection_poses((2.8, 3.8), free, RESOLUTION, distance) == []
    fence = np.zeros(SHAPE, dtype=bool)
    fence[45:56, 45:56] = True
    fence[46:55, 46:55] = False
    assert inspection_poses((1.01, 1.01), free, RESOLUTION, distance, occluders=fence) == []
    assert math.isfinite(float(distance[40, 40]))
