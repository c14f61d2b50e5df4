"""What was touched is an obstacle from then on, and the rover backs off straight from it."""

from __future__ import annotations

import math

import numpy as np
from rover.geometry import Pose2
from rover.mission.config import Area, Launch
from rover.mission.contacts import BACK_OFF_M, BACK_OFF_SPEED, Contacts
from rover.mission.drive import Drive
from rover.mission.freespace import free_space
from rover.motion.segment import State, after
from rover.vehicle import STANDARD

AREA = Area(3.0, 3.0, ((0.3, 0.3, 0.05),))
AT = Pose2(1.5, 1.5, math.pi / 2)


def test_the_ground_before_the_hull_is_an_obstacle_and_a_place_10_cm_back_is_free() -> None:
    contacts = Contacts()
    assert contacts.added_to(AREA) is AREA
    contacts.touch(AT, STANDARD)
    seen = np.ones((150, 150), bool)
    space = free_space(~seen, seen, 0.02, (), contacts.added_to(AREA), Launch(Pose2(0.5, 0.5, 0.0), 0.25), STANDARD)
    for bearing in (-0.7, 0.0, 0.7):
        reach = STANDARD.radius + 0.03
        x, y = AT.transform(np.array([[reach * math.cos(bearing), reach * math.sin(bearing)]]))[0]
        assert space.occluders[int(y / 0.02), int(x / 0.02)]
    assert not space.free[75, 75]
    assert space.free[int((1.5 - BACK_OFF_M) / 0.02), 75]
    assert contacts.count == 1
    assert space.occluders[15, 15], "what was given stays"


def test_backing_off_is_slow_straight_and_ends_at_rest() -> None:
    drive = Drive(STANDARD, 0.25)
    drive.back_off(BACK_OFF_M, BACK_OFF_SPEED)
    state, now, slowest = State(), 0.0, 0.0
    while not drive.at_rest(now):
        for segment in drive.step(now, AT)[0]:
            state = after(state, segment)
            slowest = min(slowest, state.speed)
        now += 0.02
        assert now < 5.0
    assert abs(state.travel + BACK_OFF_M) < 1e-4
    assert state.heading == 0.0
    assert state.at_rest
    assert -BACK_OFF_SPEED - 1e-3 < slowest < -0.5 * BACK_OFF_SPEED
