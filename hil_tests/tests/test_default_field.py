"""A mission of only the required keys has a field that can be laid, whatever its area and seed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from rover.mission.config import load
from rover_hil.ground.field import site_of
from rover_hil.ground.placement import place

AREAS = [(3.0, 4.0), (3.0, 3.0), (2.5, 3.0), (2.0, 2.0), (1.5, 4.0), (1.5, 1.5), (1.0, 1.0), (1.2, 8.0), (1.0, 12.0)]


@pytest.mark.parametrize(("width", "height"), AREAS)
def test_the_default_field_fits_the_area(tmp_path: Path, width: float, height: float) -> None:
    file = tmp_path / "only.toml"
    file.write_text(f"[area]\nwidth_m = {width}\nheight_m = {height}\n[launch]\nx_m = 0.4\ny_m = 0.4\n")
    mission = load(file)
    mines = mission.field.surface_mines + len(mission.field.buried_mine_depths)
    for seed in range(8):
        rng = np.random.default_rng(seed)
        radii = rng.uniform(0.06, 0.18, mission.field.rocks + mission.field.grass).tolist()
        layout = place(site_of(mission), radii, mines, rng)
        assert len(layout.mines) == mines
