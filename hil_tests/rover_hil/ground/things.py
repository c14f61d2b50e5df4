"""Rocks, grass tufts and pebbles: how each changes the temperature and the height of the ground."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rover_hil.ground.heat import Case, Inclusion, simulate
from rover_hil.ground.raster import Grid
from rover_hil.ground.soils import CLEAR_DAY, ROCK, STEFAN_BOLTZMANN, Material, Weather
from rover_hil.ground.texture import correlated_noise

# Thickness of the simulated rock, m.
ROCK_COLUMN_M = 0.18
# Share of S(t) that reaches a face turned away from the sun.
SHADE = 0.70
# Cooling of soil in a rock's shadow at full sun.
SHADOW_KELVIN = 1.5
# W/(m² K): thin blades exchange heat better than flat soil.
LEAF_CONVECTION = 35.0
# Share of absorbed sunlight that evaporates water.
TRANSPIRED = 0.55


@dataclass(frozen=True)
class Hour:
    """Temperatures at one hour of the day, K, and the sun's place: unit vector towards it, 0..1 strength."""

    soil: float
    rock_lit: float
    rock_shaded: float
    leaf: float
    sun_x: float
    sun_y: float
    sun_height: float
    sunlight: float


def leaf_temperature(hour: float, weather: Weather = CLEAR_DAY) -> float:
    """Lumped canopy balance: sunlight less transpiration, convection, long-wave exchange with the sky, K."""
    air, sky = float(weather.air(hour)), float(weather.sky(hour))
    absorbed = 0.78 * (1 - TRANSPIRED) * float(weather.irradiance(hour))
    leaf = air
    for _ in range(10):  # Newton
        balance = absorbed + LEAF_CONVECTION * (air - leaf) + 0.97 * STEFAN_BOLTZMANN * (sky**4 - leaf**4)
        leaf += balance / (LEAF_CONVECTION + 4 * 0.97 * STEFAN_BOLTZMANN * leaf**3)
    return leaf


def at_hour(soil: Material, hour: float, weather: Weather = CLEAR_DAY) -> Hour:
    """Everything that depends on the hour: three simulated columns, the leaf balance and the sun's place."""
    rock = Inclusion(ROCK, math.inf, ROCK_COLUMN_M, 0.0)
    surface = simulate([Case(soil), Case(soil, rock), Case(soil, rock, sunlight=SHADE)], weather).at(hour)[
        :, 0
    ]
    # The sun goes from east (+x) over south (−y) to west; at noon it stands 60° high.
    phase = (hour - weather.sunrise_hour) / (weather.sunset_hour - weather.sunrise_hour)
    up = math.sin(math.pi * phase) if 0.0 < phase < 1.0 else 0.0
    return Hour(
        soil=float(surface[0]),
        rock_lit=float(surface[1]),
        rock_shaded=float(surface[2]),
        leaf=leaf_temperature(hour, weather),
        sun_x=math.cos(math.pi * phase) if up else 0.0,
        sun_y=-math.sin(math.pi * phase) if up else 0.0,
        sun_height=math.radians(60.0) * up,
        sunlight=up,
    )


def _outline(
    dx: NDArray[np.float64], dy: NDArray[np.float64], depth: float, rng: np.random.Generator
) -> NDArray[np.float64]:
    """Radius factor per cell, in [1 − depth, 1]: a closed crooked outline that never leaves the circle."""
    angle = np.arctan2(dy, dx)
    waves = np.zeros_like(angle)
    for n in (2, 3, 5):
        waves += rng.uniform(0.3, 1.0) / n * np.cos(n * angle + rng.uniform(0, 2 * np.pi))
    factor: NDArray[np.float64] = 1 - depth * (0.5 + 0.5 * waves / max(float(np.abs(waves).max()), 1e-9))
    return factor


def lay_rock(
    temperature: NDArray[np.float32],
    height: NDArray[np.float32],
    grid: Grid,
    rock: tuple[float, float, float, float],
    now: Hour,
    rng: np.random.Generator,
) -> None:
    """Lay a rock (x, y, radius, height) with its sunlit and its shaded side and its shadow, in place."""
    x, y, r, top = rock
    if now.sunlight > 0.0:
        _lay_shadow(temperature, grid, rock, now)
    window = grid.window((x, y), r)
    dx, dy = grid.offsets(window, (x, y))
    rho = np.hypot(dx, dy) / (r * _outline(dx, dy, 0.15, rng))
    inside = rho < 1.0
    facing = (dx * now.sun_x + dy * now.sun_y) / r
    lit = np.clip(0.5 + 0.5 * facing, 0.0, 1.0)
    grain = rng.standard_normal(rho.shape) * 0.3
    warmth = now.rock_shaded + lit * (now.rock_lit - now.rock_shaded) + rng.uniform(-1.0, 1.0) + grain
    temperature[window] = np.where(inside, warmth, temperature[window])
    dome = top * (1 - 0.55 * np.clip(rho, 0, 1) ** 4)
    height[window] = np.where(inside, np.maximum(dome, 0.0), height[window])


def _lay_shadow(
    temperature: NDArray[np.float32], grid: Grid, rock: tuple[float, float, float, float], now: Hour
) -> None:
    x, y, r, top = rock
    length = min(top / max(math.tan(now.sun_height), 0.3), 0.45)
    window = grid.window((x, y), r + length + 0.15)
    dx, dy = grid.offsets(window, (x, y))
    along = -(dx * now.sun_x + dy * now.sun_y)
    across = dx * now.sun_y - dy * now.sun_x
    # Distance to the swept disc: the rock's circle drawn out along the shadow, soft at the rim.
    outside = np.hypot(along - np.clip(along, 0.0, length), across) - r
    temperature[window] -= (SHADOW_KELVIN * now.sunlight / (1 + np.exp(outside / 0.025))).astype(np.float32)


def lay_grass(
    temperature: NDArray[np.float32],
    height: NDArray[np.float32],
    grid: Grid,
    tuft: tuple[float, float, float, float],
    now: Hour,
    rng: np.random.Generator,
) -> None:
    """Lay a tuft (x, y, radius, height): blades over soil, cooler by day through transpiration, in place."""
    x, y, r, top = tuft
    window = grid.window((x, y), r)
    dx, dy = grid.offsets(window, (x, y))
    rho = np.hypot(dx, dy) / (r * _outline(dx, dy, 0.30, rng))
    local = Grid(0.0, 0.0, grid.resolution, rho.shape[1], rho.shape[0])
    blades = correlated_noise(local, 0.02, 1.0, rng)
    cover = np.clip(1.3 * (1 - rho**4) + 0.35 * blades, 0.0, 1.0) * (rho < 1.0)
    kelvin = 0.6 * cover * (now.leaf - temperature[window]) + cover * 0.4 * blades
    temperature[window] += kelvin.astype(np.float32)
    height[window] += (top * cover * (0.75 + 0.25 * np.tanh(blades))).astype(np.float32)


def lay_pebbles(
    temperature: NDArray[np.float32],
    height: NDArray[np.float32],
    grid: Grid,
    now: Hour,
    rng: np.random.Generator,
    per_square_metre: float = 5.0,
) -> None:
    """Scatter pebbles (radius 0.8 to 2.5 cm) over the whole raster, in place: features, and no obstacles."""
    width, length = grid.columns * grid.resolution, grid.rows * grid.resolution
    towards_rock = 0.5 * (now.rock_lit + now.rock_shaded) - now.soil
    for _ in range(round(per_square_metre * width * length)):
        centre = (grid.origin_x + rng.uniform(0, width), grid.origin_y + rng.uniform(0, length))
        r = rng.uniform(0.008, 0.025)
        # A small stone follows the soil that it lies on; only a part of a rock's contrast is left.
        kelvin = np.clip(rng.uniform(0.05, 0.25) * towards_rock + rng.uniform(-0.4, 0.4), -2.0, 2.0)
        window = grid.window(centre, 1.5 * r)
        rho = np.hypot(*grid.offsets(window, centre)) / r
        shape = 1 / (1 + rho**6)
        temperature[window] += (kelvin * shape).astype(np.float32)
        height[window] += (0.5 * r * shape).astype(np.float32)
