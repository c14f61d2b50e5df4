"""The comparison with toppra measures what it says."""

from __future__ import annotations

import math

import pytest
from rover.motion.path.blend import blend_path
from rover.motion.path.limits import DrivingLimits
from rover.vehicle import Vehicle

from tools.bench import trajectory

LIMITS = DrivingLimits.of(Vehicle())


def test_toppra_on_a_line_is_the_trapezoid_and_on_a_corner_the_fastest_turn() -> None:
    pytest.importorskip("toppra", reason="toppra is not installed")
    stretches = blend_path([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)], LIMITS, trajectory.BlendSettings(max_cut=0.0))
    driving, turning = trajectory.toppra_times(stretches, LIMITS)
    assert driving == pytest.approx(2 * (1.0 / 0.25 + 0.25 / 0.5), rel=2e-2)
    assert turning == pytest.approx(math.pi / 2 / 1.2 + 1.2 / 3.0, rel=1e-6)


@pytest.mark.parametrize("seed", [0, 1, 2, 3])
def test_limits_and_ground_are_kept_and_the_same_seed_gives_the_same_path(seed: int) -> None:
    pytest.importorskip("toppra", reason="toppra is not installed")
    outcome, again = (trajectory.measure(seed, LIMITS) for _ in range(2))
    assert outcome.broken == ()
    assert (outcome.duration, outcome.toppra) == (again.duration, again.toppra)
    assert 0.98 < outcome.duration / outcome.toppra < 1.3
