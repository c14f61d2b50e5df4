"""Specification: what an earlier visit leaves to a second one, and where its mosaic lies in the second's map."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from rover.errors import BadInput
from rover.geometry import Pose2
from rover.mission.earlier_visit import moved
from rover.mission.visit_again import check_same_field

RESOLUTION = 0.02


@pytest.mark.parametrize("shift", [Pose2(0.1, -0.06, 0.0), Pose2(-0.05, 0.08, math.radians(2.0)), Pose2(0.0, 0.0, 0.0)])
def test_a_mosaic_lies_where_the_shift_takes_its_map(shift: Pose2) -> None:
    y, x = (np.mgrid[0:100, 0:120] + 0.5) * RESOLUTION
    spot = np.array([[1.1, 0.9]])
    kelvin = (290.0 + np.exp(-((x - spot[0, 0]) ** 2 + (y - spot[0, 1]) ** 2) / 0.05**2)).astype(np.float32)
    kelvin[:20] = np.nan
    laid = moved(kelvin, shift, RESOLUTION)
    weight = np.where(np.isfinite(laid), np.maximum(laid - 290.2, 0.0), 0.0)
    found = np.array([(weight * x).sum(), (weight * y).sum()]) / weight.sum()
    assert np.abs(found - shift.transform(spot)[0]).max() < 0.003
    assert laid.shape == kelvin.shape
    assert np.isnan(laid[:14]).all()
    assert np.nanmin(laid) == pytest.approx(290.0, abs=0.01)  # no edge fades into what is not known


def test_the_field_of_another_seed_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="not there, or damaged"):
        check_same_field(tmp_path, 3)
    (tmp_path / "truth.json").write_text(json.dumps({"seed": 4}))
    with pytest.raises(BadInput, match="driven with --seed 4"):
        check_same_field(tmp_path, 3)
    check_same_field(tmp_path, 4)
