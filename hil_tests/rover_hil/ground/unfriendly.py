"""The effects of a world on the ground's temperature: soil that varies with a cause, weather, shadows."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rover_hil.ground.clutter import Clutter, lay_clutter
from rover_hil.ground.layer import Layer
from rover_hil.ground.raster import Grid
from rover_hil.ground.soils import Material
from rover_hil.ground.things import at_hour
from rover_hil.ground.weather import cloud_layer, lay_dew, shadow_layers, wind_layer
from rover_hil.world.file import World

# Streams of random numbers of a field's seed: one for each effect, so that none changes another.
SOIL, CLOUDS, WIND, TREES, DEW, LITTER, MINES = range(201, 208)


def lay_soil_with_causes(world: World, grid: Grid, soil: Material, hour: float, seed: int) -> Clutter | None:
    """The soil of a world with clutter; None where the even texture stays. One seed is one soil at every hour."""
    sizes = world.sizes("ground.clutter")
    return None if sizes is None else lay_clutter(grid, soil, hour, sizes, np.random.default_rng([seed, SOIL]))


def lay_weather(
    world: World,
    temperature: NDArray[np.float32],
    grid: Grid,
    area: tuple[float, float],
    soil: Material,
    hour: float,
    seconds: int,
    seed: int,
    clutter: Clutter | None,
) -> tuple[Layer, ...]:
    """Dew and shadows into the raster, in place; what changes over a mission of so many seconds comes back."""

    def stream(number: int) -> np.random.Generator:
        # Weather is another one at every hour; trees stay where they are.
        return np.random.default_rng([seed, number, round(hour * 60.0)])

    layers: list[Layer] = [] if clutter is None else [clutter.layer(seconds)]
    dew, shadows, clouds, wind = (world.sizes(f"weather.{name}") for name in ("dew", "shadows", "clouds", "wind"))
    if dew is not None:
        lay_dew(temperature, grid, hour, dew["wetness"], stream(DEW))
    if shadows is not None:
        trees = np.random.default_rng([seed, TREES])
        shade, wandering = shadow_layers(grid, area, soil, hour, shadows, seconds, trees)
        temperature += shade
        layers += wandering
    even = np.ones(grid.shape, np.float32)
    if clouds is not None:
        answer = even if clutter is None else clutter.absorbed / clutter.inertia
        layers.append(cloud_layer(answer, soil, hour, clouds, seconds, stream(CLOUDS)))
    if wind is not None:
        answer = even if clutter is None else 1.0 / clutter.inertia
        layers.append(wind_layer(answer, soil, at_hour(soil, hour), hour, wind, seconds, stream(WIND)))
    return tuple(layer for layer in layers if np.any(layer.series))
