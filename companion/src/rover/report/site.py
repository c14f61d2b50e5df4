"""Where a survey was made, and for whom: what a mission file may say of its site."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Georeference:
    """Where the map's origin lies on WGS 84, degrees; bearing_deg: compass bearing of map +y (0: +y points north)."""

    latitude: float
    longitude: float
    bearing_deg: float = 0.0


@dataclass(frozen=True)
class Site:
    """Names are "" and the origin is None where the mission file does not give them."""

    name: str = ""
    organisation: str = ""
    operator: str = ""
    origin: Georeference | None = None

    def document(self) -> dict[str, Any]:
        """As in summary.json."""
        origin = self.origin
        return {
            "name": self.name,
            "organisation": self.organisation,
            "operator": self.operator,
            "origin": None if origin is None else [origin.latitude, origin.longitude],
            "bearing_deg": None if origin is None else origin.bearing_deg,
        }


UNKNOWN = Site()
