"""A camera that shows nothing has the rover stand, and ends the mission when it stays so."""

from __future__ import annotations

import numpy as np
import pytest
from rover.capture.frame import Frame
from rover.mission.sight import BLIND_AFTER, LOST_AFTER, SHUT_AFTER, Sight

CYCLE = 0.02
WITHOUT_SIGHT = [("none", LOST_AFTER, "lost"), ("shut", SHUT_AFTER, "still"), ("doubtful", SHUT_AFTER, ": raw counts")]


def frame(at: float, shut: bool = False, doubt: str | None = None) -> Frame:
    return Frame(np.zeros((2, 2), np.uint16), at, 0, shut, doubt=doubt)


def watch(sight: Sight, begin: float, end: float, pictures: str) -> None:
    for now in np.arange(begin, end, CYCLE).tolist():
        due = round(now / CYCLE) % 6 == 0
        doubt = "raw counts" if pictures == "doubtful" else None
        sight.take(now, [frame(now, pictures in ("shut", "doubtful"), doubt)] if due and pictures != "none" else [])


def test_pictures_that_come_nine_times_a_second_are_enough():
    sight = Sight()
    watch(sight, 0.0, 60.0, "open")
    assert (sight.blind(60.0), sight.lost(60.0)) == (False, None)


def test_a_closed_shutter_of_two_seconds_is_waited_for_in_motion():
    sight = Sight()
    watch(sight, 0.0, 5.0, "open")
    watch(sight, 5.0, 7.0, "shut")
    assert not sight.blind(7.0)


@pytest.mark.parametrize(("pictures", "patience", "why"), WITHOUT_SIGHT)
def test_without_sight_the_rover_stands_and_gives_up_later(pictures, patience, why):
    sight = Sight()
    watch(sight, 0.0, 5.0, "open")
    watch(sight, 5.0, 5.0 + patience, pictures)
    assert not sight.blind(5.0 + BLIND_AFTER - 0.2)
    assert sight.blind(5.0 + BLIND_AFTER + 0.2)
    assert sight.lost(5.0 + patience - 0.2) is None
    assert why in (sight.lost(5.0 + patience + 0.2) or "")


def test_with_the_first_new_picture_it_sees_again():
    sight = Sight()
    watch(sight, 0.0, 5.0, "open")
    watch(sight, 5.0, 12.0, "none")
    assert sight.blind(12.0)
    watch(sight, 12.0, 12.2, "open")
    assert (sight.blind(12.2), sight.lost(12.2)) == (False, None)


def test_a_camera_that_never_gave_a_picture_is_lost_too():
    sight = Sight()
    watch(sight, 3.0, 3.0 + LOST_AFTER + 0.2, "none")
    assert sight.lost(3.0 + LOST_AFTER + 0.2)
