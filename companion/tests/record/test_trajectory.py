"""Trajectories go out and come back, and their error is the plain distance in map."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from rover.errors import BadInput
from rover.record.ate import absolute_trajectory_error
from rover.record.tum import read_tum, write_tum


def test_tum_round_trip(tmp_path: Path) -> None:
    poses = np.array([[0.0, 1.0, 2.0, 0.0], [0.5, 1.25, 2.5, -3.0], [1.0, 0.0, 0.0, math.pi / 2]])
    write_tum(tmp_path / "t.tum", poses)
    assert np.allclose(read_tum(tmp_path / "t.tum"), poses, atol=1e-6)
    assert (tmp_path / "t.tum").read_text().splitlines()[1].count(" ") == 7


def test_a_bad_line_is_named(tmp_path: Path) -> None:
    (tmp_path / "t.tum").write_text("# x\n0 0 0 0 0 0 0 1\n1 2 3\n")
    with pytest.raises(BadInput, match=r"t\.tum:3"):
        read_tum(tmp_path / "t.tum")


def test_error_is_not_aligned_away() -> None:
    truth = np.array([[t, t, 0.0] for t in np.linspace(0.0, 10.0, 101)])
    estimate = np.array([[t, t + 0.03, 0.04] for t in np.linspace(0.0, 10.0, 37)])
    assert absolute_trajectory_error(estimate, truth) == pytest.approx(0.05)


def test_only_common_times_count_and_there_must_be_some() -> None:
    truth = np.array([[0.0, 0.0, 0.0], [1.0, 1.0, 0.0]])
    estimate = np.array([[0.5, 0.5, 0.0], [9.0, 50.0, 0.0]])
    assert absolute_trajectory_error(estimate, truth) == pytest.approx(0.0)
    with pytest.raises(BadInput, match="overlap"):
        absolute_trajectory_error(estimate[1:], truth)
