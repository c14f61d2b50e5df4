"""The comparison with toppra measures what it says, and the bench's own integration finds what is wrong."""

from __future__ import annotations

import math

import numpy as np
import pytest
from rover.motion.path.blend import blend_path
from rover.motion.path.limits import DrivingLimits
from rover.motion.path.rounding import BlendSettings
from rover.motion.segment import Segment
from rover.vehicle import Vehicle

from tools.bench.trajectory.independent import broken, distance, integrate
from tools.bench.trajectory.measure import measure
from tools.bench.trajectory.paths import KINDS
from tools.bench.trajectory.toppra_peer import shape_time, toppra_times

LIMITS = DrivingLimits.of(Vehicle())


def test_toppra_on_a_line_is_the_trapezoid_and_on_a_corner_the_fastest_turn() -> None:
    pytest.importorskip("toppra", reason="toppra is not installed")
    stretches = blend_path([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)], LIMITS, BlendSettings(max_cut=0.0)).stretches
    driving, turning = toppra_times(stretches, LIMITS)
    assert driving == pytest.approx(2 * (1.0 / 0.25 + 0.25 / 0.5), rel=2e-2)
    assert turning == pytest.approx(math.pi / 2 / 1.2 + 1.2 / 3.0, rel=1e-6)
    line = np.column_stack([np.linspace(0.0, 1.0, 500), np.zeros(500)])
    assert shape_time(line, LIMITS) == pytest.approx(1.0 / 0.25 + 0.25 / 0.5, rel=2e-2)


@pytest.mark.parametrize(
    "kind", [kind for kind in KINDS if kind not in ("mower", "long walk", "circle", "line", "sine")]
)
def test_limits_tolerance_and_clearance_are_kept_and_the_same_seed_gives_the_same_path(kind: str) -> None:
    outcome, again = (measure(kind, 2, LIMITS, peer=False) for _ in range(2))
    assert outcome.refused == ""
    assert outcome.broken == ()
    assert (outcome.duration, outcome.segments) == (again.duration, again.segments)


def test_the_integration_finds_what_is_exceeded_and_where_the_rover_comes_to() -> None:
    # A quarter turn on the spot would be 1.57 rad; then straight on at 0.3 m/s, too fast, and no rest at the end.
    rows = [Segment(1_000_000, 300_000, 0, True), Segment(1_000_000, -300_000, 0), Segment(1_000_000, 0, 0)]
    motion = integrate(rows, 1.0, 2.0, math.pi / 2)
    assert motion.positions[-1] == pytest.approx([1.0, 2.0 + 0.05 + 0.25 + 0.3])
    assert broken(motion, LIMITS) == ["speed", "rest at the end"]
    assert distance(np.array([[0.5, 0.2], [2.0, 0.0]]), np.array([[0.0, 0.0], [1.0, 0.0]])) == pytest.approx([0.2, 1.0])
