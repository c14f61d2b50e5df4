"""A plant on chosen ground, for tests of one part of its physics at a time."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rover_plant import Plant

RESOLUTION_M = 0.01
ORIGIN_M = -1.0
# Cells along a side of the test ground: from -1 m to 5 m in both axes.
SIDE_CELLS = 600

QUIET_CAMERA = {"netd": 0.0, "row_pattern": 0.0, "column_pattern": 0.0, "pixel_pattern": 0.0, "vignetting": 0.0}
NO_SLIP = {"slip_bias": 0.0, "slip_noise": 0.0}
SAME_MOTORS = {"motor_tolerance": 0.0}


def cell_centres() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """x and y of the test ground's cells, both (SIDE_CELLS, SIDE_CELLS)."""
    line = ORIGIN_M + (np.arange(SIDE_CELLS) + 0.5) * RESOLUTION_M
    x, y = np.meshgrid(line, line)
    return x, y


def make_plant(
    temperature: NDArray[Any] | None = None,
    height: NDArray[Any] | None = None,
    obstacles: list[list[float]] | None = None,
    **config: Any,
) -> Plant:
    """A plant on flat ground of 300 K unless given otherwise; area 4 m × 4 m, launch at (2, 2) along x."""
    raster = {"raster_origin_x": ORIGIN_M, "raster_origin_y": ORIGIN_M, "raster_resolution": RESOLUTION_M}
    place = {"area_width": 4.0, "area_height": 4.0, "launch": {"x": 2.0, "y": 2.0, "heading": 0.0}}
    flat = np.zeros((SIDE_CELLS, SIDE_CELLS), dtype=np.float32)
    return Plant(
        json.dumps({**raster, **place, **config}),
        (flat + 300.0 if temperature is None else temperature).astype(np.float32),
        (flat if height is None else height).astype(np.float32),
        np.array(obstacles or [], dtype=np.float64).reshape(-1, 4),
    )


def drive(plant: Plant, left: float, right: float, seconds: float) -> None:
    """Holds both duties for a while."""
    for _ in range(round(seconds * 1000)):
        plant.step(left, right, True)
