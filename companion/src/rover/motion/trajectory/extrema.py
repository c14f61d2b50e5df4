"""How much a row of quantised segments asks of both axes, against the limits."""

from __future__ import annotations

from dataclasses import astuple, dataclass

from rover.motion.path.limits import DrivingLimits


@dataclass(frozen=True)
class Extrema:
    """Largest magnitudes (SI) over all segments; `lateral` is speed × turn rate."""

    speed: float
    acceleration: float
    jerk: float
    turn_rate: float
    turn_acceleration: float
    turn_jerk: float
    lateral: float

    @classmethod
    def allowed(cls, limits: DrivingLimits) -> Extrema:
        """The most that each may be."""
        travel, heading = limits.travel, limits.heading
        return cls(
            travel.speed,
            travel.acceleration,
            travel.jerk,
            heading.speed,
            heading.acceleration,
            heading.jerk,
            limits.lateral,
        )

    def broken(self, limits: DrivingLimits) -> str:
        """Which limit is exceeded, in words; empty when none is."""
        names = ("speed", "acceleration", "jerk", "turn rate", "turn acceleration", "turn jerk", "lateral acceleration")
        for name, value, bound in zip(names, astuple(self), astuple(Extrema.allowed(limits)), strict=True):
            if not value <= bound:
                return f"{name} of {value:.6g} exceeds {bound:g}"
        return ""
