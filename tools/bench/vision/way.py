"""Ways through a field that keep clear of obstacles, and what slipping wheels report along them."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from rover.geometry import Pose2, wrap_angle
from rover.vehicle import Vehicle
from rover_hil.ground import Ground

STEP_M = 0.02
SPEED, ACCELERATION = 0.25, 0.5
TURN_SPEED, TURN_ACCELERATION = 1.1, 3.0
CLEARANCE, MARGIN = 0.18, 0.35
MIN_LEG_M = 0.5
# Slip wanders within a third of its bound and forgets itself over half a metre.
WANDER_SHARE, WANDER_LENGTH = 1.0 / 3.0, 0.5

Place = tuple[float, float]


@dataclass(frozen=True)
class Drive:
    """poses: the truth every STEP_M. left, right: what the wheels report for each step between them, metres."""

    poses: list[Pose2]
    left: list[float]
    right: list[float]


def along(start: Pose2, places: Sequence[Place]) -> list[Pose2]:
    """From `start` straight to each place in turn, turning on the spot; speeds are trapezoids."""
    poses = [start]
    for x, y in places:
        here = poses[-1]
        turn = wrap_angle(math.atan2(y - here.y, x - here.x) - here.heading)
        for angle in _trapezoid(abs(turn), TURN_SPEED, TURN_ACCELERATION):
            poses.append(Pose2(here.x, here.y, wrap_angle(here.heading + math.copysign(angle, turn))))
        here = poses[-1]
        for s in _trapezoid(math.hypot(x - here.x, y - here.y), SPEED, ACCELERATION):
            poses.append(here.compose(Pose2(s, 0.0, 0.0)))
    return poses


def _trapezoid(length: float, speed: float, acceleration: float) -> list[float]:
    """Positions every STEP_M from rest to rest, ending exactly at `length`."""
    peak = min(speed, math.sqrt(length * acceleration))
    if peak <= 0.0:
        return []
    ramp = peak / acceleration
    total = length / peak + ramp
    made = []
    for step in range(1, math.ceil(total / STEP_M) + 1):
        t = min(step * STEP_M, total)
        rest = total - t
        if t < ramp:
            made.append(0.5 * acceleration * t * t)
        elif rest > ramp:
            made.append(peak * (t - 0.5 * ramp))
        else:
            made.append(length - 0.5 * acceleration * rest * rest)
    return made


def is_free(a: Place, b: Place, ground: Ground) -> bool:
    """True where the leg from `a` to `b` passes every obstacle with room to spare."""
    share = np.linspace(0.0, 1.0, 50)
    x, y = a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])
    return all(
        float(np.hypot(x - ox, y - oy).min()) > radius + CLEARANCE for ox, oy, radius, _ in ground.obstacles.tolist()
    )


def free_place(ground: Ground, rng: np.random.Generator) -> Place:
    """A random place in the area, clear of obstacles."""
    while True:
        x, y = (float(rng.uniform(MARGIN, side - MARGIN)) for side in ground.area)
        place = x, y
        if is_free(place, place, ground):
            return place


def wander(ground: Ground, start: Place, length: float, rng: np.random.Generator) -> list[Place]:
    """Random places in the area, reached on free legs, until `length` metres are driven."""
    places, here, driven = [], start, 0.0
    while driven < length:
        there = free_place(ground, rng)
        leg = math.dist(here, there)
        if leg >= MIN_LEG_M and is_free(here, there, ground):
            places.append(there)
            here, driven = there, driven + leg
    return places


def circuit(ground: Ground, rng: np.random.Generator) -> list[Place]:
    """A closed way over three or more places on free legs; the first is where it starts and ends."""
    while True:
        first = free_place(ground, rng)
        places = [first, *wander(ground, first, 2.5, rng)]
        if is_free(places[-1], first, ground) and math.dist(places[-1], first) >= MIN_LEG_M:
            return places


def reported(poses: list[Pose2], slip: float, rng: np.random.Generator) -> Drive:
    """Wheel reports: each wheel's scale is off by a constant within ±slip and wanders on top; whole encoder counts."""
    vehicle = Vehicle()
    constant = rng.uniform(-slip, slip, 2)
    wandering, exact, counted = np.zeros(2), np.zeros(2), np.zeros(2)
    left, right = [], []
    for a, b in itertools.pairwise(poses):
        step = b.relative_to(a)
        ahead = math.copysign(math.hypot(step.x, step.y), step.x)
        true = ahead + step.heading * vehicle.track_width / 2.0 * np.array([-1.0, 1.0])
        share = np.minimum(1.0, np.abs(true) / WANDER_LENGTH)
        wandering += -share * wandering + np.sqrt(2.0 * share) * WANDER_SHARE * slip * rng.standard_normal(2)
        exact += true * (1.0 + constant + wandering)
        whole = np.floor(exact / vehicle.metres_per_count) * vehicle.metres_per_count
        left.append(float(whole[0] - counted[0]))
        right.append(float(whole[1] - counted[1]))
        counted = whole
    return Drive(poses, left, right)
