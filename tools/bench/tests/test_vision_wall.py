"""What the façade's tables measure against: the wall's plane by survey and poses, and steps at the pictures' edges."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from rover.vision.mosaic.picture_graph import Placement

from tools.bench.vision.facade import marker_transfer
from tools.bench.vision.seams import seam_table
from tools.bench.vision.truth import facade


def test_the_walls_plane_by_survey_and_poses_transfers_the_markers() -> None:
    if "ROVER_DATA" not in os.environ:
        pytest.skip("ROVER_DATA is not set: no real pictures")
    wall = facade(Path(os.environ["ROVER_DATA"]))
    apart = [d for k in range(25) for d in marker_transfer(wall, k, k + 1, wall.across(k, k + 1))]
    assert len(apart) >= 25
    assert max(apart) < 2.0


def test_an_offset_between_two_pictures_is_a_step_where_they_are_laid_on_each_other_and_none_where_stitched() -> None:
    rng = np.random.default_rng(3)
    ground = rng.normal(4000.0, 2.0, (256, 512))
    pictures = [(ground[:, x : x + 320] + offset).astype(np.uint16) for x, offset in ((0, 0.0), (120, 50.0))]
    placed = Placement(0, {0: np.eye(3), 1: np.array([[1.0, 0.0, 120.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])}, 0.0)
    stitched, pasted, without = (float(row.split("|")[2]) for row in seam_table(pictures, placed).splitlines()[2:])
    assert pasted > 20.0  # the lower picture's edge is covered: half of the edges step by 50
    assert stitched < 5.0
    assert without < 5.0
