"""Keep-out zones: the one place that says where no wheel may go because a mine may lie there.

Invariant: from the moment a place is suspected, a disc around it is kept free of wheels until the place is
dismissed. Planning, path checks and the referee of simulated rigs all read the zones from here.

A place that is first suspected close beside the rover can't have a whole zone at once, for wheels stand where it would
be. Its zone begins where the wheels can't reach any more and grows to its full radius as the rover leaves.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from rover.detection.place import Anchor
from rover.geometry import Pose2

# A zone is drawn anew once its place has moved by this much; less is noise of the position.
REDRAW_DISTANCE = 0.01

# A growing zone is drawn anew in steps of at least this, metres.
GROWTH = 0.01

# Half the extent of a mine, metres: no zone is smaller.
MINE_RADIUS_M = 0.06


class SuspectedPlace(Protocol):
    """What a zone needs to know of a place (`rover.detection.fusion`)."""

    @property
    def id(self) -> int: ...
    @property
    def x(self) -> float: ...
    @property
    def y(self) -> float: ...
    @property
    def anchor(self) -> Anchor | None: ...


@dataclass(frozen=True)
class Zone:
    """A disc in map, metres, valid from `since` until `until` (companion clock; None: still valid).

    anchor: from where its place was seen when it was drawn. The zone lies on the ground as seen from there, whatever
    becomes of the map: while it is valid both move together, and it is no new zone.
    """

    id: int
    x: float
    y: float
    radius: float
    since: float
    until: float | None = None
    anchor: Anchor | None = None


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

    def move(self, shifts: Mapping[int, Pose2]) -> None:
        """Places have moved in map with the ground that they were seen on, by number; their zones move with them."""
        for number, shift in shifts.items():
            zone = self._active.get(number)
            if zone is None:
                continue
            x, y = shift.transform(np.array([[zone.x, zone.y]]))[0].tolist()
            anchor = zone.anchor and Anchor(zone.anchor.time, shift.compose(zone.anchor.pose))
            self._active[number] = replace(zone, x=x, y=y, anchor=anchor)

    def update(
        self,
        suspected: Iterable[SuspectedPlace],
        now: float,
        rover: tuple[float, float] | None = None,
        reach: float = 0.0,
    ) -> bool:
        """Brings the zones in line with the places suspected now; True when any zone changed.

        `reach`: how far from `rover`, in map, its wheels may still come before it stands; metres.
        """
        changed = False
        seen = set()
        for place in suspected:
            seen.add(place.id)
            zone = self._active.get(place.id)
            radius = self._radius
            if rover is not None:
                radius = min(radius, math.hypot(place.x - rover[0], place.y - rover[1]) - reach)
            if zone is not None:
                moved = math.hypot(zone.x - place.x, zone.y - place.y)
                # A disc that lies inside the old one covers no new ground, wherever the rover is.
                radius = max(radius, zone.radius - moved)
                if moved < REDRAW_DISTANCE and radius < min(zone.radius + GROWTH, self._radius):
                    continue
                if moved < REDRAW_DISTANCE and zone.radius >= self._radius:
                    continue
                self._ended.append(replace(zone, until=now))
            radius = max(radius, MINE_RADIUS_M)
            self._active[place.id] = Zone(place.id, place.x, place.y, radius, now, anchor=place.anchor)
            changed = True
        for identifier in [key for key in self._active if key not in seen]:
            self._ended.append(replace(self._active.pop(identifier), until=now))
            changed = True
        return changed
