"""What the bumper has touched: places that become obstacles, though nothing had shown them.

The switches do not say where on the front the touch was. All of the ground just ahead of the hull counts as solid, as
far to the sides as the rover can have struck anything while going forward.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from rover.geometry import Pose2
from rover.mission.config import Area
from rover.vehicle import Vehicle

# Bearings from the hull's centre at which ground counts as solid, radians, and how deep it is believed to be, metres.
BEARINGS = tuple(math.radians(angle) for angle in (-50.0, -25.0, 0.0, 25.0, 50.0))
HALF_DEPTH = 0.035
# How far the rover backs off after a touch, metres: until its margin is free again.
BACK_OFF_M = 0.10
# At which speed, m/s: no sensor looks behind, and the ground there bears, as the wheels came over it.
BACK_OFF_SPEED = 0.08


@dataclass
class Contacts:
    """All touches of a mission. discs: x, y, radius in map, metres."""

    count: int = 0
    discs: list[tuple[float, float, float]] = field(default_factory=list)

    def touch(self, pose: Pose2, vehicle: Vehicle) -> None:
        """One more, felt by a rover that stands at the pose."""
        self.count += 1
        reach = vehicle.radius + HALF_DEPTH
        places = pose.transform(np.array([[reach * math.cos(b), reach * math.sin(b)] for b in BEARINGS]))
        self.discs += [(x, y, HALF_DEPTH) for x, y in places.tolist()]

    def added_to(self, area: Area) -> Area:
        """The area with these places among its obstacles."""
        return replace(area, obstacles=(*area.obstacles, *self.discs)) if self.discs else area
