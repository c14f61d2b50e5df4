"""Keep-out zones: the one place that says where no wheel may go because a mine may lie there.

Invariant: from the moment a place is suspected, a disc around it is kept free of wheels until the place is
dismissed. Planning, path checks and the referee of simulated rigs all read the zones from here.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Protocol

# A zone is drawn anew once its place has moved by this much; less is noise of the position.
REDRAW_DISTANCE = 0.01


class SuspectedPlace(Protocol):
    """What a zone needs to know of a place (`rover.detection.fusion`)."""

    id: int
    x: float
    y: float


@dataclass(frozen=True)
class Zone:
    """A disc in map, metres, valid from `since` until `until` (companion clock; None: still valid)."""

    id: int
    x: float
    y: float
    radius: float
    since: float
    until: float | None = None


class KeepOut:
    """The zones that are valid now, and every zone that has ever been."""

    def __init__(self, radius: float) -> None:
        self._radius = radius
        self._active: dict[int, Zone] = {}
        self._ended: list[Zone] = []

    @property
    def active(self) -> list[Zone]:
        """Zones valid now, by the number of their place."""
        return [self._active[key] for key in sorted(self._active)]

    @property
    def history(self) -> list[Zone]:
        """Every zone that has been valid at some time, in the order of `since`."""
        return sorted([*self._ended, *self._active.values()], key=lambda zone: (zone.since, zone.id))

    def update(self, suspected: Iterable[SuspectedPlace], now: float) -> bool:
        """Brings the zones in line with the places suspected now; True when any zone changed."""
        changed = False
        seen = set()
        for place in suspected:
            seen.add(place.id)
            zone = self._active.get(place.id)
            if zone is not None:
                if (zone.x - place.x) ** 2 + (zone.y - place.y) ** 2 < REDRAW_DISTANCE**2:
                    continue
                self._ended.append(replace(zone, until=now))
            self._active[place.id] = Zone(place.id, place.x, place.y, self._radius, now)
            changed = True
        for identifier in [key for key in self._active if key not in seen]:
            self._ended.append(replace(self._active.pop(identifier), until=now))
            changed = True
        return changed
