"""A spot on the ground that a detector has an opinion of."""

from __future__ import annotations

from typing import Protocol


class ClassifiedSpot(Protocol):
    """What the map needs to know of a detection (`rover.detection.ground.detect`): base_link, metres."""

    @property
    def x(self) -> float: ...
    @property
    def y(self) -> float: ...
    @property
    def extent(self) -> float: ...
    @property
    def p(self) -> dict[str, float]: ...
