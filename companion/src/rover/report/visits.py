"""Two visits to one field, as a result: how their maps lie on each other, and what each found of every indication."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Raster = NDArray[np.float32]


@dataclass(frozen=True)
class PlaceVisits:
    """Of one indication. first, second: probability of a mine by that visit, None where it did not report one.

    together: by the temperatures of both. contrast: to the ground around at each visit, kelvin, nan where not known.
    inertia: apparent thermal inertia as a share of that of the ground around; None where it can't be told.
    """

    first: float | None
    second: float | None
    together: float
    contrast: tuple[float, float]
    inertia: float | None

    @property
    def found_by(self) -> str:
        """In words, for people."""
        return {
            (True, True): "both visits",
            (True, False): "the first",
            (False, True): "the second",
            (False, False): "only both together",
        }[self.first is not None, self.second is not None]


@dataclass(frozen=True, eq=False)
class TwoVisitsResult:
    """earlier: folder of the first visit. hours: of the day. shift: x, y (m), heading (deg) of its map in this one.

    registered_by, matches, agreement: see `rover.vision.localization.map_registration.Registered`.
    first, second, difference: rasters like the map's temperature, kelvin. places: by the number of the indication.
    """

    earlier: str
    hours: tuple[float, float]
    registered_by: str
    shift: tuple[float, float, float]
    matches: int
    agreement: float
    first: Raster
    second: Raster
    difference: Raster
    places: dict[int, PlaceVisits]


def visits_json(visits: TwoVisitsResult) -> dict[str, Any]:
    """As in summary.json; nan becomes null."""
    x, y, heading = visits.shift
    return {
        "after": visits.earlier,
        "hours": [round(hour, 3) for hour in visits.hours],
        "registered_by": visits.registered_by,
        "shift": {"x": round(x, 4), "y": round(y, 4), "heading_deg": round(heading, 3)},
        "matches": visits.matches,
        "agreement": round(visits.agreement, 3),
        "places": [
            {
                "id": number,
                "first_p": _rounded(place.first),
                "second_p": _rounded(place.second),
                "together_p": round(place.together, 4),
                "contrast_k": [_rounded(value) for value in place.contrast],
                "thermal_inertia": _rounded(place.inertia),
            }
            for number, place in sorted(visits.places.items())
        ],
    }


def _rounded(value: float | None) -> float | None:
    return None if value is None or not math.isfinite(value) else round(value, 4)
