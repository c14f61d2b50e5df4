"""What the ground is made of and the weather above it: the constants of the heat model."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from rover.errors import BadInput

DAY_S = 86_400.0
# W/(m² K⁴)
STEFAN_BOLTZMANN = 5.670374419e-8


@dataclass(frozen=True)
class Material:
    """A homogeneous solid: conductivity W/(m K), heat capacity J/(m³ K), short-wave albedo, emissivity."""

    conductivity: float
    heat_capacity: float
    albedo: float = 0.25
    emissivity: float = 0.95

    @property
    def diffusivity(self) -> float:
        """Thermal diffusivity a = k/(ρc) in m²/s."""
        return self.conductivity / self.heat_capacity

    @property
    def damping_depth(self) -> float:
        """Depth in metres at which the daily wave has fallen to 1/e: √(aP/π)."""
        return math.sqrt(self.diffusivity * DAY_S / math.pi)


# Orders of magnitude of textbook tables (dry to moist); the damping depths lie between 8 and 14 cm.
SOILS: dict[str, Material] = {
    "dry-sand": Material(conductivity=0.30, heat_capacity=1.28e6, albedo=0.35),
    "loam": Material(conductivity=1.00, heat_capacity=2.00e6, albedo=0.20),
    "clay": Material(conductivity=0.80, heat_capacity=2.10e6, albedo=0.24),
    "moist-clay": Material(conductivity=1.55, heat_capacity=2.90e6, albedo=0.16),
}

# The soil of the reference contrasts: a = 5e-7 m²/s.
REFERENCE_SOIL = "loam"

# Plastic casing around TNT.
MINE = Material(conductivity=0.20, heat_capacity=1.80e6)
# Olive-drab paint.
CASING_ALBEDO = 0.18
ROCK = Material(conductivity=2.60, heat_capacity=2.20e6, albedo=0.28)


def soil_named(name: str) -> Material:
    """The soil called `name` (spaces, hyphens and underscores are the same).

    Raises:
        BadInput: no such soil.
    """
    key = name.strip().lower().replace("_", "-").replace(" ", "-")
    if key not in SOILS:
        raise BadInput(f"field.soil: no soil is called {name!r}; choose one of {', '.join(SOILS)}")
    return SOILS[key]


@dataclass(frozen=True)
class Weather:
    """A clear day that repeats itself. Kelvin, W/m², W/(m² K); hours are local solar time."""

    noon_irradiance: float = 820.0
    sunrise_hour: float = 6.0
    sunset_hour: float = 18.0
    air_mean: float = 293.15
    air_amplitude: float = 7.0
    air_peak_hour: float = 14.5
    sky_depression: float = 18.0  # the sky radiates like a black body this much colder than the air
    convection: float = 12.0

    def irradiance(self, hour: ArrayLike) -> NDArray[np.float64]:
        """Short-wave irradiance S(t), W/m², a half sine between sunrise and sunset."""
        length = self.sunset_hour - self.sunrise_hour
        phase = (np.asarray(hour, dtype=np.float64) % 24.0 - self.sunrise_hour) / length
        return self.noon_irradiance * np.where((phase > 0) & (phase < 1), np.sin(np.pi * phase), 0.0)

    def air(self, hour: ArrayLike) -> NDArray[np.float64]:
        """Air temperature, K."""
        angle = 2 * np.pi * (np.asarray(hour, dtype=np.float64) - self.air_peak_hour) / 24.0
        return self.air_mean + self.air_amplitude * np.cos(angle)

    def sky(self, hour: ArrayLike) -> NDArray[np.float64]:
        """Effective black-body temperature of the sky, K."""
        return self.air(hour) - self.sky_depression


CLEAR_DAY = Weather()
