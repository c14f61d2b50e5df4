"""Planar rigid-body geometry (REP 103: x forward, y left, heading counter-clockwise, radians)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


def wrap_angle(angle: float) -> float:
    """The same angle in [-pi, pi)."""
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


@dataclass(frozen=True)
class Pose2:
    """A pose in the plane: metres and radians."""

    x: float
    y: float
    heading: float

    def compose(self, other: Pose2) -> Pose2:
        """`other`, given in this pose's frame, in the frame that this pose is given in."""
        c, s = math.cos(self.heading), math.sin(self.heading)
        return Pose2(
            self.x + c * other.x - s * other.y,
            self.y + s * other.x + c * other.y,
            wrap_angle(self.heading + other.heading),
        )

    def inverse(self) -> Pose2:
        """The pose that composes with this one to the identity."""
        c, s = math.cos(self.heading), math.sin(self.heading)
        return Pose2(-c * self.x - s * self.y, s * self.x - c * self.y, wrap_angle(-self.heading))

    def relative_to(self, reference: Pose2) -> Pose2:
        """This pose as seen from `reference`."""
        return reference.inverse().compose(self)

    def transform(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Points (N, 2) of this pose's frame in the outer frame, (N, 2)."""
        c, s = math.cos(self.heading), math.sin(self.heading)
        rotation = np.array([[c, -s], [s, c]])
        outer = np.asarray(points, dtype=np.float64) @ rotation.T + (self.x, self.y)
        return np.asarray(outer, dtype=np.float64)

    def distance(self, other: Pose2) -> float:
        """Distance between the two positions in metres."""
        return math.hypot(self.x - other.x, self.y - other.y)


def between(earlier: Pose2, later: Pose2, share: float) -> Pose2:
    """The pose at a share of the way from one to the other, turning the shorter way."""
    turn = wrap_angle(later.heading - earlier.heading)
    return Pose2(
        earlier.x + share * (later.x - earlier.x),
        earlier.y + share * (later.y - earlier.y),
        wrap_angle(earlier.heading + share * turn),
    )
