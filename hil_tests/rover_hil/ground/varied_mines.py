"""Mines of several sizes, each with the signature that the heat model gives for its own radius; some laid bare."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from rover_hil.ground.heat import Case, Inclusion, SurfaceHistory, simulate
from rover_hil.ground.mine import Mine
from rover_hil.ground.placement import Point
from rover_hil.ground.raster import Grid
from rover_hil.ground.signature import MINE_THICKNESS_M, SURFACE_EXPOSURE, SURFACE_MINE_HEIGHT_M, lay_signature
from rover_hil.ground.soils import CASING_ALBEDO, MINE, Material

# Share of a lid that wind and rain have laid bare.
BARE_SHARE = (0.2, 0.6)


def lay_varied_mines(
    temperature: NDArray[np.float32],
    height: NDArray[np.float32],
    grid: Grid,
    soil: Material,
    hour: float,
    centres: Sequence[Point],
    depths: Sequence[float],
    sizes: Mapping[str, float],
    rng: np.random.Generator,
) -> tuple[Mine, ...]:
    """Lays every mine, in place."""
    smallest, largest = sorted((sizes["smallest_m"], sizes["largest_m"]))
    radii = rng.uniform(smallest, largest, len(depths)).tolist()
    bodies = [_body(depth, radius) for depth, radius in zip(depths, radii, strict=True)]
    lids = [_body(0.0, radius) for radius in radii]
    now = _contrasts(soil, [*bodies, *lids], hour)
    mines = []
    for index, (centre, depth, radius) in enumerate(zip(centres, depths, radii, strict=True)):
        profile = now.temperature[index, :, 0]
        lay_signature(temperature, grid, centre, now.radius, profile)
        peak = float(profile[np.argmax(np.abs(profile))])
        window = grid.window(centre, radius)
        dx, dy = grid.offsets(window, centre)
        lid = np.hypot(dx, dy) < radius
        if depth == 0.0:
            # It lies as it fell: the lid is tilted, and sunk in by up to half.
            proud = SURFACE_MINE_HEIGHT_M * float(rng.uniform(0.4, 1.0))
            lean, towards = float(rng.uniform(0.0, 0.35)), float(rng.uniform(0.0, 2.0 * np.pi))
            top = np.maximum(proud + lean * (dx * np.cos(towards) + dy * np.sin(towards)), 0.0)
            height[window] = np.where(lid, top, height[window])
        elif rng.random() < sizes["exposed"]:
            towards, share = float(rng.uniform(0.0, 2.0 * np.pi)), float(rng.uniform(*BARE_SHARE))
            bare = lid & (dx * np.cos(towards) + dy * np.sin(towards) > radius * (1.0 - 2.0 * share))
            distance = np.hypot(dx, dy)
            change = np.interp(distance, now.radius, now.temperature[len(depths) + index, :, 0] - profile)
            temperature[window] += np.where(bare, change, 0.0).astype(np.float32)
        kind = "surface" if depth == 0.0 else "buried"
        mines.append(Mine(index + 1, *centre, radius, depth, kind, round(peak, 4)))
    return tuple(mines)


def _body(depth: float, radius: float) -> Inclusion:
    if depth <= 0.0:
        return Inclusion(MINE, radius, MINE_THICKNESS_M, 0.0, albedo=CASING_ALBEDO, exposure=SURFACE_EXPOSURE)
    return Inclusion(MINE, radius, MINE_THICKNESS_M, depth)


def _contrasts(soil: Material, bodies: Sequence[Inclusion], hour: float) -> SurfaceHistory:
    """Surface temperatures over the bodies less that of plain soil, at one hour: (bodies, nr, 1)."""
    history = simulate([Case(soil), *(Case(soil, body) for body in bodies)])
    at = history.at(hour)
    return SurfaceHistory(history.radius, np.array([hour]), (at[1:] - at[0])[..., None])
