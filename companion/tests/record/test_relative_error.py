"""The error among things: blind to where the map as a whole lies, and to nothing else."""

from __future__ import annotations

import math

import numpy as np
import pytest
from rover.errors import BadInput
from rover.geometry import Pose2
from rover.record.relative_error import RelativePose, relative_error

TIME = np.arange(0.0, 20.0, 0.01)
OFFSET = 0.1


def circle(time: float) -> Pose2:
    """The true way: a circle of 2 m in 20 s."""
    angle = 2.0 * math.pi * time / 20.0
    return Pose2(2.0 * math.cos(angle), 2.0 * math.sin(angle), angle + math.pi / 2)


TRUTH = np.array([(t, p.x, p.y, p.heading) for t, p in ((t, circle(t)) for t in TIME.tolist())])


def believed(off: Pose2, error: Pose2, sigma: float = 0.01) -> list[RelativePose]:
    """A map that lies at `off` as a whole, in which the rover is wrong by `error`, given in its own frame."""
    return [
        RelativePose(
            t,
            0.5 * t,
            off.compose(circle(t)).compose(error).relative_to(off.compose(circle(0.5 * t))),
            sigma**2 * np.eye(2),
        )
        for t in np.arange(1.0, 19.0, 0.37).tolist()
    ]


def test_a_map_that_lies_elsewhere_as_a_whole_makes_no_error() -> None:
    rmse, inside = relative_error(believed(Pose2(0.3, -0.2, 0.1), Pose2(0.0, 0.0, 0.0)), TRUTH, OFFSET)
    assert rmse < 1e-4
    assert inside == 1.0


def test_an_error_among_things_is_told_in_metres_of_the_wheels() -> None:
    rmse, inside = relative_error(believed(Pose2(0.3, -0.2, 0.1), Pose2(0.02, 0.0, 0.0)), TRUTH, OFFSET)
    assert rmse == pytest.approx(0.02, abs=1e-4)
    assert inside == 1.0
    assert relative_error(believed(Pose2(0.0, 0.0, 0.0), Pose2(0.03, 0.0, 0.0)), TRUTH, OFFSET)[1] == 0.0
    turned = relative_error(believed(Pose2(0.0, 0.0, 0.0), Pose2(0.0, 0.0, 0.05)), TRUTH, OFFSET)
    assert turned[0] == pytest.approx(0.05 * OFFSET, rel=1e-2)


def test_of_an_honest_estimate_95_of_100_are_inside() -> None:
    rng = np.random.default_rng(1)
    poses = []
    for t in rng.uniform(1.0, 19.0, 4000).tolist():
        dx, dy = (rng.standard_normal(2) * 0.01).tolist()
        real = circle(t).relative_to(circle(0.5 * t))
        poses.append(RelativePose(t, 0.5 * t, Pose2(real.x + dx, real.y + dy, real.heading), 1e-4 * np.eye(2)))
    assert 0.93 < relative_error(poses, TRUTH, OFFSET)[1] < 0.97


def test_what_the_truth_does_not_cover_is_left_out() -> None:
    late = RelativePose(30.0, 1.0, Pose2(0.0, 0.0, 0.0), np.eye(2))
    with pytest.raises(BadInput, match="known time"):
        relative_error([late], TRUTH, OFFSET)
    with pytest.raises(BadInput, match="no truth"):
        relative_error([late], np.empty((0, 4)), OFFSET)
