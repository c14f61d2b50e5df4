"""Small things that are no mines and look a little like some: pebbles, holes, scrap, grass of every height."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from rover_hil.ground.raster import Grid
from rover_hil.ground.things import Hour

Raster = NDArray[np.float32]


def _places(
    grid: Grid, per_square_metre: float, low: float, high: float, rng: np.random.Generator
) -> list[tuple[tuple[float, float], float]]:
    """Centres anywhere on the raster, and radii in [low, high], m."""
    width, length = grid.columns * grid.resolution, grid.rows * grid.resolution
    count = int(rng.poisson(per_square_metre * width * length))
    x = grid.origin_x + rng.uniform(0.0, width, count)
    y = grid.origin_y + rng.uniform(0.0, length, count)
    radii = rng.uniform(low, high, count)
    return [((px, py), r) for px, py, r in zip(x.tolist(), y.tolist(), radii.tolist(), strict=True)]


def lay_litter(
    temperature: Raster, height: Raster, grid: Grid, now: Hour, sizes: Mapping[str, float], rng: np.random.Generator
) -> None:
    """Everything of the effect `things.litter`, in place."""
    for centre, r in _places(grid, sizes["holes_per_m2"], 0.015, 0.05, rng):
        # A hole is shaded and sees itself: the deep soil's temperature, between day and night.
        _disc(temperature, grid, centre, r, float(rng.uniform(0.2, 0.6)) * (291.0 - now.soil))
        _disc(height, grid, centre, r, -float(rng.uniform(0.5, 1.5)) * r)
    for centre, r in _places(grid, sizes["scrap_per_m2"], 0.008, 0.04, rng):
        # Bare metal mirrors the sky, which is colder than anything on the ground; rust does not.
        mirrored = float(rng.uniform(0.1, 0.9)) * sizes["scrap_mirrors"]
        _disc(temperature, grid, centre, r, -mirrored * (now.soil - 265.0))
        _disc(height, grid, centre, r, float(rng.uniform(0.0, 0.02)))
    for centre, r in _places(grid, sizes["tufts_per_m2"], 0.02, 0.07, rng):
        # Green grass is cooler than soil by day, dry grass warmer: as warm is as likely as either.
        dry = float(rng.uniform(0.0, 1.0))
        leaf = (1.0 - dry) * now.leaf + dry * (now.soil + 0.2 * (now.soil - now.leaf))
        _disc(temperature, grid, centre, r, 0.5 * (leaf - now.soil))
        _disc(height, grid, centre, r, float(rng.uniform(0.01, sizes["tuft_m"])))


def _disc(raster: Raster, grid: Grid, centre: tuple[float, float], r: float, size: float) -> None:
    window = grid.window(centre, 1.5 * r)
    rho = np.hypot(*grid.offsets(window, centre)) / r
    raster[window] += (size / (1.0 + rho**6)).astype(np.float32)
