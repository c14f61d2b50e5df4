"""What bounds the speed along a path: limits of both axes, lateral acceleration, curvature, clearance, sight."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from rover.motion.path import corner
from rover.vehicle import Limits, Vehicle

Array = NDArray[np.float64]

# Share of each limit that is planned with: quantised durations and jerks must not exceed it.
RESERVE = 0.998


def change_distance(slow: float, fast: float, limits: Limits) -> float:
    """Metres that a change between two speeds takes, from no acceleration to none."""
    change = fast - slow
    a, j = limits.acceleration, limits.jerk
    time = change / a + a / j if change >= a * a / j else 2.0 * math.sqrt(change / j)
    return 0.5 * (slow + fast) * time


@dataclass(frozen=True)
class DrivingLimits:
    """Metres, seconds, radians.

    `lateral`: most speed × turn rate. `sight_range`, `sight_angle`: how far the sonar sees, and how far to each side;
    `latency`: from what it sees to the beginning of a stop. `clearance_time`: the margin beside the rover and `give`
    must last for so long at its speed, if it ran straight at what is there; 0 when clearance does not matter.
    """

    travel: Limits
    heading: Limits
    lateral: float = 0.25
    min_speed: float = 0.05
    sight_range: float = 2.0
    sight_angle: float = math.radians(45.0)
    latency: float = 0.13
    clearance_time: float = 0.1
    give: float = 0.01

    @classmethod
    def of(cls, vehicle: Vehicle, cruise_speed: float | None = None, lateral: float = 0.25) -> DrivingLimits:
        """The vehicle's own, at most at `cruise_speed`; its sonars give the angle of sight."""
        speed = vehicle.travel.speed if cruise_speed is None else min(cruise_speed, vehicle.travel.speed)
        angle = max((abs(mount.yaw) + mount.half_angle for mount in vehicle.sonars), default=math.pi)
        return cls(replace(vehicle.travel, speed=speed), vehicle.heading, lateral, sight_angle=angle)

    def reserved(self) -> DrivingLimits:
        """A little tighter, so that whole microseconds and quantised jerks stay within these."""
        travel, heading = (
            Limits(RESERVE * axis.speed, RESERVE * axis.acceleration, RESERVE * axis.jerk)
            for axis in (self.travel, self.heading)
        )
        return replace(self, travel=travel, heading=heading)

    def stopping_speed(self, distance: Array) -> Array:
        """The speed from which the rover comes to rest within `distance`: v²/2a + v(a/2j + latency)."""
        a, j = self.travel.acceleration, self.travel.jerk
        lag = a / (2.0 * j) + self.latency
        result: Array = a * (np.sqrt(lag * lag + 2.0 * distance / a) - lag)
        return result

    def corner_shape(self, angle: Array) -> corner.Shapes:
        """The shape of corner.py in which corners of `angle` radians are turned through soonest."""
        angle, heading = np.abs(angle)[:, None], self.heading
        rate = corner.PEAK_CURVATURE / heading.speed * angle
        acceleration = np.sqrt(corner.PEAK_SLOPE / heading.acceleration * angle)
        jerk = np.cbrt(corner.PEAK_THIRD / heading.jerk * angle)
        result: corner.Shapes = np.argmin(np.maximum(np.maximum(rate, acceleration), jerk), axis=1)
        return result

    def shared(self, share: float) -> DrivingLimits:
        """The same with `share` of what the heading may be accelerated and jerked by."""
        heading = Limits(self.heading.speed, share * self.heading.acceleration, share * self.heading.jerk)
        return replace(self, heading=heading)

    def curve_speed(self, curvature: Array, rate: Array, third: Array) -> Array:
        """Fastest constant speed along curves with at most this curvature (1/m), slope of it (1/m²) and second
        derivative of it (1/m³), magnitudes."""
        curvature, rate, third = (np.maximum(each, 1e-12) for each in (curvature, rate, third))
        heading = self.heading
        fastest = [
            heading.speed / curvature,
            np.sqrt(self.lateral / curvature),
            np.sqrt(heading.acceleration / rate),
            np.cbrt(heading.jerk / third),
            self.sight_speed(curvature),
        ]
        result: Array = np.minimum(RESERVE * np.min(fastest, axis=0), RESERVE * self.travel.speed)
        return result

    def corner_speed(self, angle: Array, length: Array, shape: corner.Shapes) -> Array:
        """Fastest constant speed through corners of `angle` radians over `length` metres of curve."""
        unit = np.abs(angle) / length
        peak, slope, third = corner.PEAK_CURVATURE[shape], corner.PEAK_SLOPE[shape], corner.PEAK_THIRD[shape]
        return self.curve_speed(peak * unit, slope * unit / length, third * unit / length**2)

    def sight_speed(self, curvature: Array) -> Array:
        """Most speed at which the rover stops within the arc of this curvature (1/m) that its sonars cover."""
        return self.stopping_speed(np.minimum(self.sight_range, 2.0 * self.sight_angle / np.maximum(curvature, 1e-12)))

    def corner_length(self, angle: Array, shape: corner.Shapes) -> Array:
        """The shortest curve that takes corners of `angle` radians at full speed, by all but sight."""
        angle = np.abs(angle)
        v, heading = self.travel.speed, self.heading
        peak = corner.PEAK_CURVATURE[shape] * angle
        needed = [
            peak * v / heading.speed,
            peak * v * v / self.lateral,
            v * np.sqrt(corner.PEAK_SLOPE[shape] * angle / heading.acceleration),
            v * np.cbrt(corner.PEAK_THIRD[shape] * angle / heading.jerk),
        ]
        result: Array = np.max(needed, axis=0)
        return result

    def clearance_speed(self, margin: Array) -> Array:
        """Most speed where a disc of the rover's size has `margin` to each side."""
        if self.clearance_time <= 0.0:
            return np.full(np.shape(margin), self.travel.speed)
        result: Array = np.clip((margin + self.give) / self.clearance_time, self.min_speed, self.travel.speed)
        return result
