"""How a source is named on a command line: `kind:location?option=value&option=value`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from rover.capture.frame import KELVIN_PER_COUNT
from rover.errors import BadInput

# What one count means, in kelvin; None: a sensor's own counts.
UNITS: Mapping[str, float | None] = {"centikelvin": KELVIN_PER_COUNT, "decikelvin": 0.1, "raw": None}


@dataclass(frozen=True)
class Location:
    """Where a source reads, with its options; every reader of an option says what it would have accepted."""

    place: str
    options: Mapping[str, str]

    @staticmethod
    def parse(text: str, known: tuple[str, ...]) -> Location:
        """Splits `place?key=value&…`. Raises BadInput for an option that is not `known`."""
        place, _, query = text.partition("?")
        options: dict[str, str] = {}
        for pair in filter(None, query.split("&")):
            key, separator, value = pair.partition("=")
            if key not in known or not separator or not value:
                raise BadInput(f"{text}: option '{pair}' is not known; known: {', '.join(f'{k}=…' for k in known)}")
            options[key] = value
        return Location(place, options)

    def unit(self, default: str) -> float | None:
        """Kelvin per count from `unit=centikelvin|decikelvin|raw`."""
        name = self.options.get("unit", default)
        if name not in UNITS:
            raise BadInput(f"{self.place}: unit={name}: one of {', '.join(UNITS)} is expected")
        return UNITS[name]

    def number(self, key: str, default: float) -> float:
        """A positive number."""
        text = self.options.get(key)
        if text is None:
            return default
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not (math.isfinite(value) and value > 0.0):
            raise BadInput(f"{self.place}: {key}={text}: a positive number is expected")
        return value

    def size(self) -> tuple[int, int] | None:
        """(width, height) from `size=WxH`; None where it is not given."""
        text = self.options.get("size")
        if text is None:
            return None
        width, _, height = text.lower().partition("x")
        if not (width.isdigit() and height.isdigit() and int(width) and int(height)):
            raise BadInput(f"{self.place}: size={text}: WIDTHxHEIGHT in pixels is expected")
        return int(width), int(height)
