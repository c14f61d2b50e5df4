"""Thermal clutter with a cause: properties of the soil that vary from place to place, through the heat model.

The surface's temperature is linear in small deviations of each property, with the heat model's own derivative at that
hour: where the derivative changes its sign over the day so does the pattern, and properties that matter by day (albedo)
leave the field to those that matter at night (conductivity, heat capacity).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from rover_hil.ground.heat import Case, Inclusion, SurfaceHistory, simulate
from rover_hil.ground.layer import Layer
from rover_hil.ground.raster import Grid
from rover_hil.ground.soils import CLEAR_DAY, Material, Weather
from rover_hil.ground.texture import sum_of_scales
from rover_hil.ground.things import leaf_temperature

# (correlation length in m, rms): octaves of the contrast of real clay soil from 3 to 10 m above it, medians of 80
# pictures of the landmine set (Tenorio-Tamayo et al., Data in Brief 49:109443). Below 1 cm they resolve nothing.
SPECTRUM = ((0.32, 0.227), (0.16, 0.220), (0.08, 0.191), (0.04, 0.146), (0.02, 0.083), (0.01, 0.060))
# A step in a property, with which its derivative is taken.
ALBEDO_STEP, SHARE_STEP, WATER_STEP = 0.02, 0.05, 0.02
# Per share of volume that is water (Campbell and Norris, An Introduction to Environmental Biophysics, chapter 8):
# J/(m3 K); relative conductivity; albedo, which falls by about half from dry to wet.
WATER_CAPACITY, WATER_CONDUCTIVITY, WATER_ALBEDO = 4.18e6, 3.0, -0.5
# Share of the sunlight that each further hundredth of water turns into vapour instead of warmth: moist soil evaporates
# about half of what it takes in, dry soil nothing, and 0.25 lies between them.
WATER_EVAPORATION = 2.0
# Seconds of the longest trend that is drawn.
TREND_S = 1800.0
COLUMN_M = 0.6


@dataclass(frozen=True)
class Clutter:
    """Soil as it varies: rasters (rows, columns) of temperature and of its drift in K/s.

    absorbed, inertia: shares of what the nominal soil takes up of the sun, and of its thermal inertia.
    """

    temperature: NDArray[np.float32]
    drift: NDArray[np.float32]
    absorbed: NDArray[np.float32]
    inertia: NDArray[np.float32]

    def layer(self, seconds: int) -> Layer:
        """The drift over a mission of so many seconds."""
        return Layer(self.drift, np.arange(seconds + 1, dtype=np.float64))


def _column(soil: Material, exposure: float = 1.0, sunlight: float = 1.0) -> Case:
    """A column of one soil whose wind and sun are scaled."""
    body = Inclusion(soil, math.inf, COLUMN_M, 0.0, albedo=soil.albedo, exposure=exposure)
    return Case(soil, body, sunlight)


@lru_cache(maxsize=16)
def _derivatives(soil: Material, weather: Weather) -> SurfaceHistory:
    """(6, nr, nt): nominal soil; then the change by one standard step of albedo, conductivity, heat capacity, water,
    exchange with the air."""
    wet = replace(
        soil,
        heat_capacity=soil.heat_capacity + WATER_CAPACITY * WATER_STEP,
        conductivity=soil.conductivity * (1.0 + WATER_CONDUCTIVITY * WATER_STEP),
        albedo=soil.albedo * (1.0 + WATER_ALBEDO * WATER_STEP / 0.25),
    )
    history = simulate(
        [
            _column(soil),
            _column(replace(soil, albedo=soil.albedo + ALBEDO_STEP)),
            _column(replace(soil, conductivity=soil.conductivity * (1.0 + SHARE_STEP))),
            _column(replace(soil, heat_capacity=soil.heat_capacity * (1.0 + SHARE_STEP))),
            _column(wet, sunlight=1.0 - WATER_EVAPORATION * WATER_STEP),
            _column(soil, exposure=1.0 + SHARE_STEP),
        ],
        weather,
    )
    temperature = history.temperature.copy()
    temperature[1:] -= temperature[0]
    return SurfaceHistory(history.radius, history.hour, temperature)


def lay_clutter(
    grid: Grid,
    soil: Material,
    hour: float,
    sizes: Mapping[str, float],
    rng: np.random.Generator,
    weather: Weather = CLEAR_DAY,
) -> Clutter:
    """Soil of which each property differs from place to place by the standard deviations in `sizes`.

    The same rng state lays the same soil whatever the hour: two visits see one ground at two hours.
    """
    day = _derivatives(soil, weather)
    now = day.at(hour)[:, 0]
    later = day.at(hour + TREND_S / 3600.0)[:, 0]
    deviations = (
        sizes["albedo"] / ALBEDO_STEP,
        sizes["conductivity"] / SHARE_STEP,
        sizes["heat_capacity"] / SHARE_STEP,
        sizes["moisture"] / WATER_STEP,
        sizes["roughness"] / SHARE_STEP,
    )
    temperature = np.full(grid.shape, now[0], np.float32)
    drift = np.full(grid.shape, (later[0] - now[0]) / TREND_S, np.float32)
    fields = []
    for index, size in enumerate(deviations, start=1):
        part = spectral_noise(grid, rng)
        fields.append(part)
        temperature += part * np.float32(size * now[index])
        drift += part * np.float32(size * (later[index] - now[index]) / TREND_S)
    albedo, conductivity, capacity, water, _ = fields
    absorbed = 1.0 - (sizes["albedo"] * albedo + WATER_ALBEDO * soil.albedo * sizes["moisture"] * water) / (
        1.0 - soil.albedo
    )
    inertia = np.exp(0.5 * (sizes["conductivity"] * conductivity + sizes["heat_capacity"] * capacity))
    inertia *= 1.0 + 0.5 * (WATER_CONDUCTIVITY + WATER_CAPACITY / soil.heat_capacity) * sizes["moisture"] * water
    _lay_blades(temperature, grid, hour, sizes["vegetation"], rng, weather)
    return Clutter(temperature, drift, absorbed.astype(np.float32), inertia.astype(np.float32))


def spectral_noise(grid: Grid, rng: np.random.Generator) -> NDArray[np.float32]:
    """Noise (rows, columns) of unit rms with the spectrum of real soil."""
    noise = sum_of_scales(grid, SPECTRUM, rng)
    return np.asarray(noise / np.float32(max(float(noise.std()), 1e-9)), np.float32)


def _lay_blades(
    temperature: NDArray[np.float32],
    grid: Grid,
    hour: float,
    cover: float,
    rng: np.random.Generator,
    weather: Weather,
) -> None:
    """Single blades and rosettes over `cover` of the ground: each pixel is a mixture of leaf and soil. In place."""
    noise = spectral_noise(grid, rng)
    if cover <= 0.0:
        return
    least = np.quantile(noise[::4, ::4], 1.0 - min(2.0 * cover, 1.0))
    share = np.clip((noise - least) / 2.0, 0.0, 0.5).astype(np.float32)
    temperature += share * (np.float32(leaf_temperature(hour, weather)) - temperature)
