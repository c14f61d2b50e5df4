"""Weather that changes within minutes: clouds, gusts, shadows that wander, dew. Each becomes layers over the ground.

Ground answers to a step of heat flux q as a half space that loses heat to the air: q/h (1 - exp(x²) erfc(x)) with
x = h √t / P, P the thermal inertia √(kρc) (Carslaw and Jaeger, Conduction of Heat in Solids, 2.7).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from rover_hil.ground.clutter import spectral_noise
from rover_hil.ground.layer import Layer
from rover_hil.ground.raster import Grid
from rover_hil.ground.soils import CLEAR_DAY, STEFAN_BOLTZMANN, Material, Weather
from rover_hil.ground.things import Hour

# Between two keyframes of the wandering shadows, and how far back they are followed, seconds.
SHADOW_STEP_S, SHADOW_MEMORY_S = 300, 3600
# Shadows are worked out on cells of this size, m.
SHADOW_CELL_M = 0.04
# Share of the sun that a crown keeps out.
CROWN = 0.85
# Dew lies from two hours before sunrise and is gone so long after it, hours.
DEW_BEFORE_H, DEW_AFTER_H = 2.0, 3.0

Array = NDArray[np.float64]


def step_response(soil: Material, weather: Weather, seconds: int) -> Array:
    """Kelvin per W/m² after each second, (seconds + 1,)."""
    loss = weather.convection + 4.0 * soil.emissivity * STEFAN_BOLTZMANN * weather.air_mean**3
    inertia = math.sqrt(soil.conductivity * soil.heat_capacity)
    x = loss * np.sqrt(np.arange(seconds + 1)) / inertia
    scaled = np.array([math.exp(min(v * v, 600.0)) * math.erfc(v) if v < 20.0 else 0.564 / v for v in x.tolist()])
    return np.asarray((1.0 - scaled) / loss)


def _answer(flux: Array, soil: Material, weather: Weather) -> Array:
    """Kelvin by second to a flux by second, W/m²; 0 at second 0."""
    change = np.diff(flux, prepend=flux[0])
    return np.asarray(np.convolve(change, step_response(soil, weather, len(flux) - 1))[: len(flux)])


def _wander(seconds: int, time_s: float, rng: np.random.Generator) -> Array:
    """Ornstein-Uhlenbeck of unit variance by second, (seconds + 1,)."""
    decay = math.exp(-1.0 / time_s)
    kicks = rng.standard_normal(seconds + 1) * math.sqrt(1.0 - decay * decay)
    values = np.empty(seconds + 1)
    value = float(rng.standard_normal())
    for index, kick in enumerate(kicks.tolist()):
        value = decay * value + kick
        values[index] = value
    return values


def cloud_layer(
    answer: NDArray[np.float32],
    soil: Material,
    hour: float,
    sizes: Mapping[str, float],
    seconds: int,
    rng: np.random.Generator,
    weather: Weather = CLEAR_DAY,
) -> Layer:
    """Clouds that pass. answer (rows, columns): what each cell takes up of the sun over its inertia, nominal 1."""
    wave = _wander(seconds, sizes["period_s"] / 3.0, rng)
    # A cloud's edge takes some seconds to pass; the share of time under one is `cover`.
    limit = float(np.quantile(wave, 1.0 - sizes["cover"])) if sizes["cover"] > 0.0 else math.inf
    shade = 1.0 / (1.0 + np.exp(-(wave - limit) / 0.1))
    flux = -(1.0 - soil.albedo) * float(weather.irradiance(hour)) * sizes["depth"] * shade
    return Layer(answer, _answer(flux, soil, weather))


def wind_layer(
    answer: NDArray[np.float32],
    soil: Material,
    now: Hour,
    hour: float,
    sizes: Mapping[str, float],
    seconds: int,
    rng: np.random.Generator,
    weather: Weather = CLEAR_DAY,
) -> Layer:
    """Gusts, which cool ground that is warmer than the air. answer: one over each cell's inertia, nominal 1."""
    gust = weather.convection * sizes["gusts"] * _wander(seconds, sizes["time_constant_s"], rng)
    return Layer(answer, _answer(gust * (float(weather.air(hour)) - now.soil), soil, weather))


def shadow_layers(
    grid: Grid,
    area: tuple[float, float],
    soil: Material,
    hour: float,
    sizes: Mapping[str, float],
    seconds: int,
    rng: np.random.Generator,
    weather: Weather = CLEAR_DAY,
) -> tuple[NDArray[np.float32], tuple[Layer, ...]]:
    """Trees beyond the border, whose shadows wander with the sun: the raster of second 0 in K, and layers from there.

    Ground that was in the shade until a while ago is still cooler: the shadow has a soft rear.
    """
    trees = [_tree(area, sizes["height_m"], rng) for _ in range(round(sizes["trees"]))]
    cells = (
        max(2, math.ceil(grid.rows * grid.resolution / SHADOW_CELL_M)),
        max(2, math.ceil(grid.columns * grid.resolution / SHADOW_CELL_M)),
    )
    times = list(range(-SHADOW_MEMORY_S, seconds + SHADOW_STEP_S, SHADOW_STEP_S))
    masks = [_shade(grid, cells, trees, hour + time / 3600.0, weather) for time in times]
    response = step_response(soil, weather, SHADOW_MEMORY_S + seconds + SHADOW_STEP_S)
    frames = []
    for time in range(0, seconds + SHADOW_STEP_S, SHADOW_STEP_S):
        kelvin = masks[0] * response[time + SHADOW_MEMORY_S]
        for index, at in enumerate(times[1:], start=1):
            if at <= time:
                # A change within a step of the keyframes counts from its middle on.
                kelvin = kelvin + (masks[index] - masks[index - 1]) * response[time - at + SHADOW_STEP_S // 2]
        coarse = (-(1.0 - soil.albedo) * kelvin).astype(np.float32)
        frames.append(cv2.resize(coarse, (grid.columns, grid.rows), interpolation=cv2.INTER_LINEAR))
    clock = np.arange(seconds + 1, dtype=np.float64)
    layers = tuple(
        Layer(
            np.asarray(frame - frames[0], np.float32),
            np.clip(1.0 - np.abs(clock - number * SHADOW_STEP_S) / SHADOW_STEP_S, 0.0, 1.0),
        )
        for number, frame in enumerate(frames[1:], start=1)
    )
    return np.asarray(frames[0], np.float32), layers


def _tree(area: tuple[float, float], height: float, rng: np.random.Generator) -> tuple[float, float, float, float]:
    """x, y, height, radius of the crown of a tree to the south, where the sun is at noon, beside the area."""
    tall = height * float(rng.uniform(0.6, 1.4))
    x = float(rng.uniform(-0.6, 1.6)) * area[0]
    return x, -float(rng.uniform(0.2, 0.5)) * tall, tall, 0.12 * tall


def _shade(
    grid: Grid,
    cells: tuple[int, int],
    trees: Sequence[tuple[float, float, float, float]],
    hour: float,
    weather: Weather,
) -> Array:
    """W/m² that the trees keep from each coarse cell at an hour."""
    rows, columns = cells
    phase = (hour % 24.0 - weather.sunrise_hour) / (weather.sunset_hour - weather.sunrise_hour)
    lost = np.zeros(cells)
    if not 0.02 < phase < 0.98:
        return lost
    up = math.radians(60.0) * math.sin(math.pi * phase)
    away = -math.cos(math.pi * phase), math.sin(math.pi * phase)  # from the sun, along the ground
    x = grid.origin_x + (np.arange(columns) + 0.5) * grid.columns * grid.resolution / columns
    y = grid.origin_y + (np.arange(rows) + 0.5) * grid.rows * grid.resolution / rows
    for tree_x, tree_y, tall, radius in trees:
        along = (x[None, :] - tree_x) * away[0] + (y[:, None] - tree_y) * away[1]
        across = (y[:, None] - tree_y) * away[0] - (x[None, :] - tree_x) * away[1]
        reach = tall / math.tan(up)
        stem = (along > 0.0) & (along < reach) & (np.abs(across) < 0.03)
        crown = np.hypot((along - 0.75 * reach) * math.sin(up), across) / radius
        lost = np.maximum(lost, np.where(stem, 1.0, CROWN / (1.0 + np.minimum(crown, 9.0) ** 8)))
    return np.asarray(lost * float(weather.irradiance(hour)))


def lay_dew(
    temperature: NDArray[np.float32],
    grid: Grid,
    hour: float,
    wetness: float,
    rng: np.random.Generator,
    weather: Weather = CLEAR_DAY,
) -> None:
    """A film of water, in place: it evens the ground out, and dries in patches that stay cool until they are dry."""
    patches = spectral_noise(grid, rng)
    since = (hour - weather.sunrise_hour + 12.0) % 24.0 - 12.0
    if not -DEW_BEFORE_H < since < DEW_AFTER_H:
        return
    left = wetness * (1.0 if since < 0.0 else 1.0 - since / DEW_AFTER_H)
    film = np.clip(left + 0.3 * left * patches, 0.0, 0.95).astype(np.float32)
    mean = np.float32(temperature.mean())
    drying = np.float32(1.5 * max(since, 0.0) / DEW_AFTER_H)
    temperature += film * (mean - temperature) - drying * film
