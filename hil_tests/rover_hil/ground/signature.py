"""What a mine does to the temperature of the surface above it: radial profiles over the day, laid on a raster.

Pure functions of soil, depth and hour on top of `heat.simulate`; simulated days are cached, a raster is only
written by `lay_signature`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray
from rover.capture.radiometry import ZERO_CELSIUS

from rover_hil.ground.heat import Case, Inclusion, SurfaceHistory, simulate
from rover_hil.ground.raster import Grid
from rover_hil.ground.soils import CASING_ALBEDO, CLEAR_DAY, MINE, Material, Weather, soil_named

# Of a buried mine; between those of one that stands on the surface.
MINE_RADIUS_M = 0.055
SURFACE_MINE_RADII_M = (0.050, 0.060)
MINE_THICKNESS_M = 0.05
# What stands out of the soil.
SURFACE_MINE_HEIGHT_M = 0.04
# A little more convection than flat soil: the side loses heat too, but it also takes up sunlight.
SURFACE_EXPOSURE = 1.15


def mine_case(soil: Material, depth: float) -> Case:
    """The ground over one mine: `depth` metres of soil above it; 0 is a mine that stands on the surface."""
    if depth <= 0.0:
        body = Inclusion(
            MINE, MINE_RADIUS_M, MINE_THICKNESS_M, 0.0, albedo=CASING_ALBEDO, exposure=SURFACE_EXPOSURE
        )
    else:
        body = Inclusion(MINE, MINE_RADIUS_M, MINE_THICKNESS_M, depth)
    return Case(soil, body)


@dataclass(frozen=True)
class DailyContrasts:
    """A day over undisturbed soil, (nt,) K, and of mines minus that soil, `contrast.temperature` (depths, nr, nt)."""

    depths: tuple[float, ...]
    undisturbed: SurfaceHistory
    contrast: SurfaceHistory

    def profile(self, depth: float, hour: float, radius: ArrayLike) -> NDArray[np.float64]:
        """Contrast in K at distances `radius` (m, any shape) from the centre of the mine at `depth`."""
        values = self.contrast.at(hour)[self.depths.index(depth)]
        where = np.asarray(radius, dtype=np.float64)
        return np.asarray(np.interp(where, self.contrast.radius, values, right=0.0))


@lru_cache(maxsize=64)
def _daily_contrasts(soil: Material, depths: tuple[float, ...], weather: Weather) -> DailyContrasts:
    history = simulate([Case(soil), *(mine_case(soil, depth) for depth in depths)], weather)
    bare, mined = history.temperature[:1], history.temperature[1:]
    contrast = mined - bare
    # Beyond the last cell there is nothing of the mine left: let the profile end at exactly zero.
    contrast = contrast - contrast[:, -1:, :]
    return DailyContrasts(
        depths,
        SurfaceHistory(history.radius[:1], history.hour, bare[:, :1]),
        SurfaceHistory(history.radius, history.hour, contrast),
    )


def daily_contrasts(
    soil: str | Material, depths: Sequence[float], weather: Weather = CLEAR_DAY
) -> DailyContrasts:
    """One simulated day of mines at `depths` (m) in `soil`; about 25 ms a depth, cached.

    Raises:
        BadInput: unknown soil name.
    """
    material = soil_named(soil) if isinstance(soil, str) else soil
    return _daily_contrasts(material, tuple(dict.fromkeys(float(d) for d in depths)), weather)


def signature(
    soil: str | Material, depth_m: float, hour: float, radius: ArrayLike, weather: Weather = CLEAR_DAY
) -> NDArray[np.float64]:
    """Surface temperature minus that of undisturbed soil, K, at distances `radius` (m) from a mine's centre.

    For several depths call `daily_contrasts` with all of them: it simulates them in one batch.
    """
    return daily_contrasts(soil, (depth_m,), weather).profile(float(depth_m), hour, radius)


def lay_signature(
    raster: NDArray[np.floating],
    grid: Grid,
    centre: tuple[float, float],
    radius: NDArray[np.float64],
    profile: NDArray[np.float64],
) -> None:
    """Add a radial profile (K at distances `radius`, both (n,), 0 beyond the last) around `centre`, in place."""
    window = grid.window(centre, float(radius[-1]))
    distance = np.hypot(*grid.offsets(window, centre))
    raster[window] += np.interp(distance, radius, profile, right=0.0).astype(raster.dtype)


TABLE_DEPTHS_M = (0.0, 0.01, 0.02, 0.05, 0.10)


def contrast_table(
    soil: str | Material = "loam", step_hours: float = 1.0, weather: Weather = CLEAR_DAY
) -> str:
    """Markdown table: contrast at the centre of mines (K) by hour and depth, then extremes and zero crossings."""
    day = daily_contrasts(soil, TABLE_DEPTHS_M, weather)
    centre = day.contrast.temperature[:, 0]
    names = ["surface", *(f"{depth * 100:g} cm" for depth in TABLE_DEPTHS_M[1:])]
    lines = ["| hour | soil °C | " + " | ".join(names) + " |", "|---" * (len(names) + 2) + "|"]
    for hour in np.arange(0.0, 24.0, step_hours):
        kelvin = day.contrast.at(hour)[:, 0]
        ground = day.undisturbed.at(hour)[0, 0] - ZERO_CELSIUS
        label = f"{int(hour):02d}:{round(hour % 1 * 60):02d}"
        lines.append(f"| {label} | {ground:.1f} | " + " | ".join(f"{value:+.2f}" for value in kelvin) + " |")
    for name, values in (("highest", centre.max(axis=1)), ("lowest", centre.min(axis=1))):
        lines.append(f"| {name} | | " + " | ".join(f"{value:+.2f}" for value in values) + " |")
    crossings = [" ".join(f"{hour:.1f}" for hour in zero_crossings(day.contrast.hour, row)) for row in centre]
    lines.append("| zero at | | " + " | ".join(crossings) + " |")
    return "\n".join(lines)


def zero_crossings(hour: NDArray[np.float64], values: NDArray[np.float64]) -> list[float]:
    """Hours at which a daily curve changes its sign, linear between samples, in [0, 24)."""
    following = np.roll(values, -1)
    at = np.nonzero(np.sign(values) * np.sign(following) < 0)[0]
    step = 24.0 / hour.size
    return sorted(float((hour[i] + step * values[i] / (values[i] - following[i])) % 24.0) for i in at)
