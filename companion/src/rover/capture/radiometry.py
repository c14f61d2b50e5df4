"""From a radiometric camera's counts to temperature: Planck's law with the camera's constants, and what lies between.

The counts are what is emitted by the object, what it reflects, and what the air before and behind the window adds, each
weakened by what comes after it. Half of the way lies on either side of the window.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from rover.errors import BadInput

# In kelvin.
ZERO_CELSIUS = 273.15


@dataclass(frozen=True)
class Surroundings:
    """What a person knows better than the camera; None: as in the file. reflected: kelvin, distance: metres."""

    emissivity: float | None = None
    reflected: float | None = None
    distance: float | None = None
    humidity: float | None = None

    def given(self) -> dict[str, float]:
        """Those that are not None, by name. Raises BadInput for one that cannot be."""
        limits = {
            "emissivity": ("--emissivity", 0.01, 1.0, 0.0),
            "reflected": ("--reflected-c", -173.15, 2726.85, ZERO_CELSIUS),
            "distance": ("--distance-m", 0.0, 1e5, 0.0),
            "humidity": ("--humidity", 0.0, 1.0, 0.0),
        }
        found: dict[str, float] = {}
        for name, (option, low, high, zero) in limits.items():
            value = getattr(self, name)
            if value is None:
                continue
            if not low <= value - zero <= high:
                raise BadInput(f"{option} {value - zero:g}: {low:g} to {high:g} is expected")
            found[name] = value
        return found

    def applied(self, radiometry: Radiometry) -> Radiometry:
        """The camera's constants with these in their place. Raises BadInput as `given`."""
        given = self.given()
        return replace(
            radiometry,
            emissivity=given.get("emissivity", radiometry.emissivity),
            reflected=given.get("reflected", radiometry.reflected),
            distance=given.get("distance", radiometry.distance),
            humidity=given.get("humidity", radiometry.humidity),
        )


@dataclass(frozen=True)
class Radiometry:
    """Constants of one picture. Temperatures in kelvin, distance in metres, the rest 0 to 1 or the camera's own.

    counts = r1 / (r2 (exp(b / T) − f)) − o for a black body at T before the lens.
    """

    emissivity: float
    distance: float
    reflected: float
    air: float
    window: float
    window_transmission: float
    humidity: float
    planck_r1: float
    planck_b: float
    planck_f: float
    planck_o: float
    planck_r2: float
    alpha: tuple[float, float]
    beta: tuple[float, float]
    mix: float

    def check(self, name: str) -> None:
        """Raises BadInput for constants that no camera has: the file is damaged there."""
        limits = {
            "emissivity": (self.emissivity, 0.01, 1.0),
            "distance": (self.distance, 0.0, 1e5),
            "reflected temperature": (self.reflected, 100.0, 3000.0),
            "air temperature": (self.air, 100.0, 500.0),
            "window transmission": (self.window_transmission, 0.01, 1.0),
            "relative humidity": (self.humidity, 0.0, 1.0),
            "atmospheric constants": (max(map(abs, (*self.alpha, *self.beta, self.mix))), 0.0, 100.0),
            "Planck R1": (self.planck_r1, 1.0, 1e9),
            "Planck B": (self.planck_b, 100.0, 1e5),
            "Planck F": (self.planck_f, 0.1, 100.0),
            "Planck R2": (self.planck_r2, 1e-9, 1e3),
            "Planck O": (self.planck_o, -1e6, 1e6),
        }
        if self.window_transmission < 1:
            limits["window temperature"] = (self.window, 100.0, 3000.0)
        for what, (value, low, high) in limits.items():
            if not low <= value <= high * (1 + 1e-6):
                raise BadInput(f"{name}: damaged thermal record: {what} of {value:g}")

    def counts_of(self, kelvin: float) -> float:
        """What a black body of that temperature gives."""
        return self.planck_r1 / (self.planck_r2 * (math.exp(self.planck_b / kelvin) - self.planck_f)) - self.planck_o

    def transmission(self, distance: float) -> float:
        """Share of the radiation that `distance` metres of this air let through (FLIR's model of water vapour)."""
        celsius = self.air - ZERO_CELSIUS
        water = self.humidity * math.exp(
            1.5587 + 6.939e-2 * celsius - 2.7816e-4 * celsius**2 + 6.8455e-7 * celsius**3
        )
        thick, thin = (
            math.exp(-math.sqrt(distance) * (alpha + beta * math.sqrt(water)))
            for alpha, beta in zip(self.alpha, self.beta, strict=True)
        )
        return self.mix * thick + (1 - self.mix) * thin

    def kelvin(self, raw: NDArray[np.uint16]) -> NDArray[np.float32]:
        """Temperatures of the object (H, W) in kelvin. NaN where the counts lie below what any temperature gives."""
        half = self.transmission(self.distance / 2)
        window, air = self.window_transmission, self.counts_of(self.air)
        share = self.emissivity * half * window * half
        foreign = (
            (1 - self.emissivity) * half * window * half * self.counts_of(self.reflected)
            + (1 - half) * window * half * air
            + (1 - half) * air
        )
        if window < 1:
            foreign += (1 - window) * half * self.counts_of(self.window)
        own = (np.arange(65536, dtype=np.float64) - foreign) / share + self.planck_o
        with np.errstate(divide="ignore", invalid="ignore"):
            table = self.planck_b / np.log(self.planck_r1 / (self.planck_r2 * own) + self.planck_f)
        table[own <= 0] = np.nan
        return table.astype(np.float32)[raw]
