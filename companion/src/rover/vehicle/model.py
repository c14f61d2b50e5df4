"""The rover's dimensions and limits, as the companion plans with them: the standard rover's, or those of a file.

The firmware holds its share as parameters, `Vehicle.parameters`; every start compares the two.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from rover_protocol.parameters import PARAMETERS

# How far beyond the middle of a wheel its tyre reaches: half as wide and half as long as its contact, with a little
# more for a tyre that gives.
TYRE_REACH_M = 0.02

# The firmware knows a left, a centre and a right one.
SONARS = 3


STANDARD_SLOPE_DEG = 15.0


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
class Pack:
    """A lithium-ion battery, from which the companion reckons how far it still lasts.

    power_w: drawn on average while driving; low_v: at which the firmware stops the rover.
    """

    cells: int = 2
    capacity_wh: float = 19.0
    resistance_ohm: float = 0.15
    power_w: float = 12.0
    low_v: float = 6.2


@dataclass(frozen=True)
class Vehicle:
    """Differential drive inside a disc; metres, radians, seconds. Sonars: left, centre, right.

    wheel_radius: of the left wheel. settings: firmware parameters, in the firmware's own units, that do not follow from
    the rest and are not at their defaults. camera: name or file, "" for the mission's choice. baud: of a serial wire.
    """

    radius: float = 0.15
    track_width: float = 0.20
    wheel_radius: float = 0.0325
    right_wheel_radius: float = 0.0325
    counts_per_revolution: int = 1560
    travel: Limits = Limits(0.25, 0.5, 3.0)
    heading: Limits = Limits(1.2, 3.0, 8.0)
    sonars: tuple[SonarMount, ...] = (
        SonarMount(0.10, 0.06, math.radians(30.0)),
        SonarMount(0.12, 0.0, 0.0),
        SonarMount(0.10, -0.06, math.radians(-30.0)),
    )

    pack: Pack = Pack()

    settings: tuple[tuple[str, int], ...] = ()
    camera: str = ""
    baud: int | None = None
    # What it may lean by at most, radians.
    max_slope: float = math.radians(STANDARD_SLOPE_DEG)

    @property
    def wheel_scales(self) -> tuple[float, float]:
        """Travel per encoder count of the left and the right wheel, metres."""
        turn = 2.0 * math.pi / self.counts_per_revolution
        return turn * self.wheel_radius, turn * self.right_wheel_radius

    @property
    def metres_per_count(self) -> float:
        """Their mean."""
        return 0.5 * sum(self.wheel_scales)

    def parameters(self) -> dict[str, int]:
        """What every parameter of this rover's firmware must be, by name, in the firmware's own units."""
        left, right = self.wheel_scales
        derived = {
            "track": round(self.track_width * 1e6),
            "count_left": round(left * 1e12),
            "count_right": round(right * 1e12),
            "low_voltage": round(self.pack.low_v * 1e3),
        }
        return {known.name: known.default for known in PARAMETERS} | derived | dict(self.settings)

    @property
    def wheel_reach(self) -> float:
        """The furthest that a tyre reaches from the rover's centre; whole micrometres."""
        return round(0.5 * self.track_width + TYRE_REACH_M, 6)


STANDARD = Vehicle()
