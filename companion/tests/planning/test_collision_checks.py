"""Collision checks against slow references that look at everything: many circles, and full squares of cells."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rover.planning import CircleField, GridField

from companion.tests.planning.slow_reference import segment_clear

SIZE = 6.0
# Far beyond the number up to which each circle is looked at.
CIRCLES = 200


def circles(seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    radii = rng.choice([0.02, 0.1, 0.6], CIRCLES) * rng.uniform(0.5, 1.0, CIRCLES)
    return np.column_stack([rng.uniform(-0.5, SIZE + 0.5, (CIRCLES, 2)), radii])


@pytest.mark.parametrize("seed", range(4))
def test_circles_found_through_buckets_are_all_circles_that_matter(seed):
    rng = np.random.default_rng(100 + seed)
    obstacles = circles(seed)
    field = CircleField(SIZE, SIZE, obstacles.tolist())
    answers = []
    for a, length, angle in zip(
        rng.uniform(0.0, SIZE, (800, 2)), rng.uniform(0.0, 3.0, 800), rng.uniform(0.0, 6.3, 800), strict=True
    ):
        b = a + length * np.array([np.cos(angle), np.sin(angle)])
        radius = float(rng.choice([0.0, 0.01, 0.05]))
        answers.append(field.segment_clear(tuple(a), tuple(b), radius))
        assert answers[-1] == segment_clear(SIZE, SIZE, obstacles.tolist(), tuple(a), tuple(b), radius)
    assert 0.02 < np.mean(answers) < 0.98


@pytest.mark.parametrize("seed", range(4))
def test_clearance_found_through_buckets_is_the_least_of_all(seed):
    points = np.random.default_rng(seed).uniform(-0.5, SIZE + 0.5, (500, 2))
    obstacles = circles(seed)
    away = np.linalg.norm(points[:, None] - obstacles[None, :, :2], axis=2) - obstacles[None, :, 2]
    walls = np.minimum(points, SIZE - points).min(axis=1)
    expected = np.minimum(away.min(axis=1), walls)
    assert CircleField(SIZE, SIZE, obstacles.tolist()).clearance(points) == pytest.approx(expected, abs=1e-9)


def squares_gap(blocked: np.ndarray, resolution: float, a: np.ndarray, b: np.ndarray) -> float:
    """Least distance between the segment and any blocked square: exact, over all of them.

    The nearest pair of points of a segment and a box contains an end of the segment or a corner of the box, unless
    they meet; they meet where the segment, cut to the box's slabs, is not empty.
    """
    rows, columns = np.nonzero(blocked)
    low = np.stack([columns, rows], axis=1) * resolution
    high = low + resolution
    step = b - a
    with np.errstate(all="ignore"):
        first, second = (low - a) / step, (high - a) / step
    enter, leave = np.minimum(first, second), np.maximum(first, second)
    for axis in np.flatnonzero(step == 0.0):
        within = (low[:, axis] <= a[axis]) & (a[axis] <= high[:, axis])
        enter[:, axis], leave[:, axis] = np.where(within, -np.inf, np.inf), np.where(within, np.inf, -np.inf)
    if (np.maximum(enter.max(axis=1), 0.0) <= np.minimum(leave.min(axis=1), 1.0)).any():
        return 0.0
    ends = [np.linalg.norm(np.maximum(np.maximum(low - p, p - high), 0.0), axis=1) for p in (a, b)]
    corners = np.concatenate([low, high, np.stack([low[:, 0], high[:, 1]], 1), np.stack([high[:, 0], low[:, 1]], 1)])
    along = np.clip((corners - a) @ step / max(step @ step, 1e-300), 0.0, 1.0)
    to_corners = np.linalg.norm(a + along[:, None] * step - corners, axis=1)
    return float(min(ends[0].min(), ends[1].min(), to_corners.min()))


@settings(max_examples=300, deadline=None, derandomize=True)
@given(
    seed=st.integers(0, 10_000),
    share=st.sampled_from([0.005, 0.03, 0.15]),
    radius=st.sampled_from([0.0, 0.03, 0.1, 0.17, 0.4, 1.0]),
    start=st.tuples(st.floats(0.0, 4.0), st.floats(0.0, 3.0)),
    end=st.tuples(st.floats(0.0, 4.0), st.floats(0.0, 3.0)),
)
def test_the_swept_check_of_a_grid_is_exact_to_its_squares(seed, share, radius, start, end):
    blocked = np.random.default_rng(seed).random((30, 40)) < share
    blocked[0, 0] = True
    a, b = np.array(start), np.array(end)
    gap = squares_gap(blocked, 0.1, a, b)
    walls = min(min(p[0], p[1], 4.0 - p[0], 3.0 - p[1]) for p in (a, b))
    if min(abs(gap - radius), abs(walls - radius)) < 1e-6:
        return  # touching: rounding decides
    clear = GridField(blocked, 0.1).segment_clear(start, end, radius)
    assert clear == (min(gap, walls) > radius)
