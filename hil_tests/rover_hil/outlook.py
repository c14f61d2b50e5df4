"""Which hours to survey at a site: what mines do to the surface by hour, beside what ground does by itself.

Ground differs from place to place in albedo, conductivity and heat capacity. What each of them does to the surface over
the day comes from the heat model too, so clutter at two hours is correlated as its causes are. A mine that is looked
for at its place stands out by d', its contrast in standard deviations of such ground; two visits together have the d'
of both temperatures (Fisher's linear discriminant).
"""

from __future__ import annotations

import datetime
from dataclasses import dataclass, replace
from itertools import combinations
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rover.toml_table import Table

from rover_hil.ground.heat import Case, simulate
from rover_hil.ground.season import Season
from rover_hil.ground.signature import mine_case
from rover_hil.ground.soils import SOILS, soil_named

STEP_HOURS = 0.5
# Deviation of the ground from place to place: of the albedo, and shares of conductivity and heat capacity.
ALBEDO, CONDUCTIVITY, HEAT_CAPACITY = 0.01, 0.04, 0.02
# What changes between two visits besides, and what the camera adds, kelvin.
BETWEEN_VISITS_K = 0.1
# All of 37 mines from this contrast on were reported on fields of other soils and hours, of weaker ones with at least
# 0.5 K three of eight (docs/results/worlds.md, companion/models/landmine_ground_found.json).
SEEN_K = 1.2
MAX_DEPTHS = 12

EXAMPLE = """\
# Where and when a survey is planned, for `rover when`.

[site]
soil = "loam"              # dry-sand, loam, clay or moist-clay
latitude_deg = 45.0        # north
date = "2026-06-21"
cloud = 0.1                # share of the sky that is covered
air_c = [13.0, 27.0]       # lowest and highest of the day
depths_cm = [0, 1, 2, 5, 7]
"""


@dataclass(frozen=True)
class Site:
    """Where and when: soil by name, depths in metres (0: on the ground), and the weather."""

    soil: str
    depths: tuple[float, ...]
    season: Season


@dataclass(frozen=True, eq=False)
class Outlook:
    """By hour (nt,): contrast (depths, nt), kelvin, and d' (depths, nt). pair: d' (depths, nt, nt) of two visits."""

    site: Site
    hour: NDArray[np.float64]
    contrast: NDArray[np.float64]
    single: NDArray[np.float64]
    pair: NDArray[np.float64]

    def seen(self) -> NDArray[np.bool_]:
        """Whether a mine at each depth is expected to be seen at each hour (depths, nt)."""
        return np.abs(self.contrast) >= SEEN_K

    def deepest(self) -> int:
        """Index of the deepest depth that is seen at any hour; the shallowest where none is."""
        seen = [index for index, row in enumerate(self.seen()) if row.any()]
        return max(seen, default=0, key=lambda index: self.site.depths[index])

    def best_hour(self, depth: int) -> int:
        """Index of the hour at which the mine stands out most."""
        return int(np.argmax(self.single[depth]))

    def best_pair(self, depth: int) -> tuple[int, int]:
        """Indices of the two hours, the earlier first, that together show the mine best."""
        pairs = combinations(range(len(self.hour)), 2)
        return max(pairs, key=lambda pair: float(self.pair[depth, pair[0], pair[1]]))


def on_day(site: Site, day: datetime.date) -> Site:
    """The same site on another day."""
    return replace(site, season=replace(site.season, day_of_year=day.timetuple().tm_yday))


def read_site(path: Path) -> Site:
    """The file that a person wrote. Raises BadInput, one line with the key."""
    table = Table.of_file(path).only("site").table("site")
    table.only("soil", "latitude_deg", "date", "cloud", "air_c", "depths_cm")
    low, high = table.row("air_c", ("lowest", "highest"), -40.0, 60.0, (13.0, 27.0))
    if low > high:
        raise table.error("air_c", f"{low:g} is the lowest and lies above {high:g}, the highest")
    depths = table.numbers("depths_cm", 0.0, 30.0, (0.0, 1.0, 2.0, 5.0, 7.0, 10.0))
    if not 0 < len(depths) <= MAX_DEPTHS:
        raise table.error("depths_cm", f"1 to {MAX_DEPTHS} depths are expected")
    season = Season(
        air_mean=273.15 + (low + high) / 2.0,
        air_amplitude=(high - low) / 2.0,
        latitude_deg=table.number("latitude_deg", -66.0, 66.0),
        day_of_year=table.date("date").timetuple().tm_yday,
        cloud=table.number("cloud", 0.0, 1.0, 0.0),
    )
    soil = table.choice("soil", tuple(SOILS))
    return Site(soil, tuple(sorted({depth / 100.0 for depth in depths})), season)


def outlook(site: Site) -> Outlook:
    """The day at the site, from the heat model: about a tenth of a second a depth."""
    soil = soil_named(site.soil)
    varied = (
        replace(soil, albedo=soil.albedo + ALBEDO),
        replace(soil, conductivity=soil.conductivity * (1.0 + CONDUCTIVITY)),
        replace(soil, heat_capacity=soil.heat_capacity * (1.0 + HEAT_CAPACITY)),
    )
    cases = [Case(soil), *(Case(other) for other in varied), *(mine_case(soil, depth) for depth in site.depths)]
    history = simulate(cases, site.season)
    hour = np.arange(0.0, 24.0, STEP_HOURS)
    surface = np.stack([history.at(each)[:, 0] for each in hour.tolist()], axis=1)
    causes, contrast = surface[1 : 1 + len(varied)] - surface[0], surface[1 + len(varied) :] - surface[0]
    clutter = causes.T @ causes + BETWEEN_VISITS_K**2 * np.eye(len(hour))
    variance = np.diag(clutter)
    single = np.abs(contrast) / np.sqrt(variance)
    determinant = np.outer(variance, variance) - clutter**2
    np.fill_diagonal(determinant, np.inf)
    squared = contrast**2
    both = squared[:, :, None] * variance + squared[:, None, :] * variance[:, None]
    both -= 2.0 * contrast[:, :, None] * contrast[:, None, :] * clutter
    pair = np.sqrt(np.maximum(both, 0.0) / determinant)
    return Outlook(site, hour, contrast, single, pair)
