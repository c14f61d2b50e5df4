"""The rover's dimensions and limits, as the companion plans with them.

The firmware holds its own copy as parameters and the plant as its configuration; a test keeps the three equal.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field


@dataclass(frozen=True)
class SonarMount:
    """Where an HC-SR04 sits on base_link, and the half-angle of its cone."""

    x: float
    y: float
    yaw: float
    half_angle: float = math.radians(15.0)


@dataclass(frozen=True)
class Limits:
    """Bounds of one axis of motion: speed, acceleration, jerk (SI)."""

    speed: float
    acceleration: float
    jerk: float


@dataclass(frozen=True)
class Vehicle:
    """Differential drive inside a disc; metres, radians, seconds."""

    radius: float = 0.15
    track_width: float = 0.20
    wheel_radius: float = 0.0325
    counts_per_revolution: int = 1560
    travel: Limits = Limits(0.25, 0.5, 3.0)
    heading: Limits = Limits(1.2, 3.0, 8.0)
    sonars: tuple[SonarMount, ...] = field(
        default=(
            SonarMount(0.10, 0.06, math.radians(30.0)),
            SonarMount(0.12, 0.0, 0.0),
            SonarMount(0.10, -0.06, math.radians(-30.0)),
        )
    )

    @property
    def metres_per_count(self) -> float:
        """Wheel travel per encoder count."""
        return 2.0 * math.pi * self.wheel_radius / self.counts_per_revolution
