"""The weather of a place on a day of the year: sun by latitude, sky and sun by clouds, for the heat model."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rover_hil.ground.soils import Weather

# A clear sky at 20 °C that radiates like a black body 18 K colder, as `Weather` has it.
CLEAR_EMISSIVITY = (275.15 / 293.15) ** 4


@dataclass(frozen=True)
class Season(Weather):
    """A day that repeats itself at a latitude, degrees north. cloud: share of the sky that is covered, 0 to 1."""

    latitude_deg: float = 45.0
    day_of_year: int = 172
    cloud: float = 0.0

    def irradiance(self, hour: ArrayLike) -> NDArray[np.float64]:
        """Short-wave irradiance, W/m². Clear: Haurwitz 1945; under clouds: Kasten and Czeplak 1980."""
        latitude = np.radians(self.latitude_deg)
        declination = np.radians(23.44) * np.sin(2.0 * np.pi * (284 + self.day_of_year) / 365.0)
        angle = np.pi * (np.asarray(hour, dtype=np.float64) - 12.0) / 12.0
        rise = np.sin(latitude) * np.sin(declination) + np.cos(latitude) * np.cos(declination) * np.cos(angle)
        up = np.maximum(rise, 1e-3)
        clear = np.where(rise > 0.0, 1098.0 * up * np.exp(-0.057 / up), 0.0)
        return np.asarray(clear * (1.0 - 0.75 * self.cloud**3.4), np.float64)

    def sky(self, hour: ArrayLike) -> NDArray[np.float64]:
        """Effective black-body temperature of the sky, K; emissivity under clouds: Unsworth and Monteith 1975."""
        emissivity = (1.0 - 0.84 * self.cloud) * CLEAR_EMISSIVITY + 0.84 * self.cloud
        return np.asarray(self.air(hour) * emissivity**0.25, np.float64)
