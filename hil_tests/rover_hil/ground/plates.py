"""Marker plates on the ground: bare aluminium that shows the camera the sky instead of itself.

A plate emits little and reflects the rest: what a camera measures is ε σ T_plate⁴ + (1 - ε) σ T_sky⁴. The sky is taken
for even, as the heat model takes it: no plate looks different from another side. Sheet metal has the air's temperature.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from rover.mission.config import Plates

from rover_hil.ground.raster import Grid
from rover_hil.ground.soils import CLEAR_DAY, Weather

# Of aluminium sheet as it is sold, which weather has dulled.
EMISSIVITY = 0.12


def plate_temperature(hour: float, weather: Weather = CLEAR_DAY) -> float:
    """What a plate looks like to a thermal camera at an hour of the day, kelvin."""
    air, sky = float(weather.air(hour)), float(weather.sky(hour))
    return float((EMISSIVITY * air**4 + (1.0 - EMISSIVITY) * sky**4) ** 0.25)


def lay_plates(
    temperature: NDArray[np.float32], height: NDArray[np.float32], grid: Grid, plates: Plates, kelvin: float
) -> None:
    """Lay square plates along the axes of map, flat on the ground, in place."""
    for x, y in plates.places:
        window = grid.window((x, y), plates.side)
        dx, dy = grid.offsets(window, (x, y))
        covered = (np.abs(dx) <= 0.5 * plates.side) & (np.abs(dy) <= 0.5 * plates.side)
        temperature[window] = np.where(covered, np.float32(kelvin), temperature[window])
        height[window] = np.where(covered, np.float32(0.0), height[window])
