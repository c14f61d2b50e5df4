"""Where and when a survey was made, and for whom: what a mission file may say of its site."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import date
from typing import Any


@dataclass(frozen=True)
class Georeference:
    """Where the map's origin lies on WGS 84, degrees; bearing_deg: compass bearing of map +y (0: +y points north)."""

    latitude: float
    longitude: float
    bearing_deg: float = 0.0


@dataclass(frozen=True)
class GridPosition:
    """Where the map's origin lies in a projected system of coordinates, metres."""

    epsg: int
    easting: float
    northing: float


@dataclass(frozen=True)
class Site:
    """Names are "" and the others None where the mission file does not give them.

    grid: as the origin was given, when not as latitude and longitude. day: of a simulated survey. weather: in the
    operator's words.
    """

    name: str = ""
    organisation: str = ""
    operator: str = ""
    origin: Georeference | None = None
    grid: GridPosition | None = None
    day: date | None = None
    weather: str = ""

    def document(self) -> dict[str, Any]:
        """As in summary.json."""
        origin, grid = self.origin, self.grid
        return {
            "name": self.name,
            "organisation": self.organisation,
            "operator": self.operator,
            "origin": None if origin is None else [origin.latitude, origin.longitude],
            "bearing_deg": None if origin is None else origin.bearing_deg,
            "epsg": None if grid is None else grid.epsg,
            "easting": None if grid is None else grid.easting,
            "northing": None if grid is None else grid.northing,
            "frame": "local only" if origin is None else "WGS 84",
            "weather": self.weather,
        }


UNKNOWN = Site()
